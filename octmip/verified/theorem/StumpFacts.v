(** What is counted of the cheapest trees of one split is a bound of them. *)

From Coq Require Import ZArith List Bool Permutation Sorting.Sorted Lia Arith.
Import ListNotations.
From octmip Require Import Samples Sums Trees Inequalities Stumps.
Open Scope Z_scope.
Local Arguments Z.add : simpl never.
Local Arguments Z.sub : simpl never.
Local Arguments Z.mul : simpl never.

(** * Orders *)

Definition key_le (c : nat) (s s' : sample) : Prop := key c s <= key c s'.

Lemma sorted_filter c keep l : StronglySorted (key_le c) l -> StronglySorted (key_le c) (filter keep l).
Proof.
  induction 1 as [|s l H IH F]; simpl; [constructor|]. destruct (keep s); auto. constructor; auto.
  rewrite Forall_forall in *. intros x I. apply filter_In in I. apply F. tauto.
Qed.

Lemma lower_of_above c th l : Forall (fun s => th < key c s) l -> lower c th l = [] /\ upper c th l = l.
Proof.
  induction 1 as [|s l H F IH]; simpl; auto. unfold is_below. destruct (Z.leb_spec (key c s) th); [lia|].
  simpl. destruct IH as [-> ->]. auto.
Qed.

(** A threshold parts an order in two. *)
Lemma sorted_parts c th l : StronglySorted (key_le c) l -> l = lower c th l ++ upper c th l.
Proof.
  induction 1 as [|s l H IH F]; [reflexivity|]. unfold lower, upper in *. cbn [filter].
  destruct (is_below c th s) eqn:B; cbn [negb app].
  - f_equal. exact IH.
  - destruct (lower_of_above c th l) as [L U].
    + unfold is_below in B. apply Z.leb_gt in B. rewrite Forall_forall in *. intros x I. specialize (F x I).
      unfold key_le in F. lia.
    + unfold lower, upper in L, U. rewrite L, U. reflexivity.
Qed.

Lemma lower_keys c th l s : In s (lower c th l) -> key c s <= th.
Proof. intros I. apply filter_In in I. destruct I as [_ I]. apply Z.leb_le in I. exact I. Qed.
Lemma upper_keys c th l s : In s (upper c th l) -> th < key c s.
Proof.
  intros I. apply filter_In in I. destruct I as [_ I]. apply negb_true_iff, Z.leb_gt in I. exact I.
Qed.

(** * Counting *)

Lemma sums_spec l : forall g m c, sums l g m c = (joined gains l g, m + total worst l, c + Z.of_nat (length l)).
Proof.
  induction l as [|s l IH]; intros g m c.
  - simpl. rewrite !Z.add_0_r. reflexivity.
  - cbn [sums total length]. rewrite IH. rewrite Nat2Z.inj_succ. unfold joined; simpl. f_equal; [f_equal|]; lia.
Qed.

Lemma keep_run place c edge is_low l :
  keep edge is_low (run_of place c l) = run_of place c (part_of place edge is_low l).
Proof.
  induction l as [|s l IH]; simpl; [reflexivity|]. unfold part_of in *. simpl.
  destruct (is_in edge is_low (place s)); simpl; rewrite IH; reflexivity.
Qed.

Lemma filter_filter (f g : sample -> bool) l :
  (forall s, f s = true -> g s = true) -> filter f (filter g l) = filter f l.
Proof.
  intros H. induction l as [|s l IH]; simpl; [reflexivity|]. specialize (H s).
  destruct (g s) eqn:G; simpl; rewrite IH; [reflexivity|]. destruct (f s); [|reflexivity].
  specialize (H eq_refl). congruence.
Qed.

(** What a cut saves. *)
Definition saving (all gone : list Z) : Z := top gone + top_gap all gone.

Section Gains.
Variable n : nat.

Lemma saving_step s all gone : sound n s -> saving all (add gone (gains s)) <= saving all gone + reach s.
Proof.
  intros S. assert (G := gain_range n s S). unfold gain in G. unfold saving.
  assert (R : 0 <= reach s) by (specialize (G 0%nat); lia).
  assert (A : top (add gone (gains s)) <= top gone + reach s).
  { apply top_le; [assert (H := top_nonneg gone); lia|]. intros i. rewrite nth_add.
    assert (H := nth_le_top gone i). specialize (G i). lia. }
  assert (B : top_gap all (add gone (gains s)) <= top_gap all gone).
  { apply top_gap_le; [apply top_gap_nonneg|]. intros i I. rewrite nth_add.
    assert (H := nth_le_top_gap all gone i I). specialize (G i). lia. }
  lia.
Qed.

Lemma saving_steps all : forall l gone, Forall (sound n) l ->
  saving all (joined gains l gone) <= saving all gone + total reach l.
Proof.
  induction l as [|s l IH]; intros gone S; simpl; [unfold joined; simpl; lia|]. inversion S as [|? ? S0 S1]; subst.
  assert (A := saving_step s all gone S0). assert (B := IH (add gone (gains s)) S1). unfold joined in *. simpl. lia.
Qed.

Lemma reach_nonneg l : Forall (sound n) l -> 0 <= total reach l.
Proof.
  intros S. apply total_nonneg. intros s I. rewrite Forall_forall in S.
  assert (G := gain_range n s (S s I) 0%nat). lia.
Qed.

(** No cut of the run saves more than what a scan returns. *)
Lemma scan_spec p place c : forall l gone count slack left most,
  Forall (sound n) l -> saving (all_gains p) gone + slack <= most -> total reach l <= left ->
  most <= scan p (run_of place c l) gone count slack left most /\
  forall l1 x s l2, l = l1 ++ x :: s :: l2 -> key c x <> key c s ->
    leaf p <= count + Z.of_nat (length (l1 ++ [x])) <= size p - leaf p ->
    saving (all_gains p) (joined gains (l1 ++ [x]) gone) <= scan p (run_of place c l) gone count slack left most.
Proof.
  induction l as [|y l IH]; intros gone count slack left most S I LE.
  - split; [simpl; lia|]. intros l1 x s l2 E. destruct l1; discriminate.
  - inversion S as [|? ? S0 S1]; subst. cbn [run_of scan].
    assert (ST := saving_step y (all_gains p) gone S0).
    cbn [total] in LE. set (gone' := add gone (gains y)) in *. set (slack' := slack - reach y). set (left' := left - reach y).
    assert (D : forall l1 x s l2, y :: l = l1 ++ x :: s :: l2 ->
      (l1 = [] /\ x = y /\ l = s :: l2) \/ (exists l1', l1 = y :: l1' /\ l = l1' ++ x :: s :: l2)).
    { intros l1 x s l2 E. destruct l1 as [|z l1]; injection E; intros; subst; [left; auto|right; eauto]. }
    destruct ((slack' <? 0) && differs (key c y) (run_of place c l)) eqn:B.
    + set (saved := top gone' + top_gap (all_gains p) gone').
      set (wide := (leaf p <=? count + 1) && (count + 1 <=? size p - leaf p)).
      set (most' := if wide then Z.max most saved else most).
      destruct (IH gone' (count + 1) (most' - saved) left' most') as [M H]; auto;
        [change (saved + (most' - saved) <= most'); rewrite Zplus_minus; apply Z.le_refl|unfold left'; lia|].
      split; [subst most'; destruct wide; lia|].
      intros l1 x s l2 E K W. destruct (D _ _ _ _ E) as [(-> & -> & ->)|(l1' & -> & ->)].
      * unfold joined. simpl. fold gone'. simpl in W. assert (Wide : wide = true).
        { subst wide. apply andb_true_iff. rewrite !Z.leb_le. lia. }
        apply Z.le_trans with most'; [|exact M]. unfold most'. rewrite Wide.
        change (saved <= Z.max most saved). apply Z.le_max_r.
      * assert (Q := H l1' x s l2 eq_refl K). unfold joined in *. simpl. apply Q.
        cbn [app length] in W. rewrite Nat2Z.inj_succ in W. lia.
    + destruct (Z.leb_spec left' slack') as [E0|E0].
      * split; [lia|]. intros l1 x s l2 E K W.
        assert (Q : Forall (sound n) (l1 ++ [x]) /\ total reach (l1 ++ [x]) <= total reach (y :: l)).
        { rewrite E. replace (l1 ++ x :: s :: l2) with ((l1 ++ [x]) ++ s :: l2) in * by (rewrite <- app_assoc; reflexivity).
          assert (SS := S). rewrite E in SS. apply Forall_app in SS. destruct SS as [SA SB]. split; [exact SA|].
          rewrite (total_app reach (l1 ++ [x])). assert (R := reach_nonneg _ SB). lia. }
        destruct Q as [Q1 Q2]. assert (R := saving_steps (all_gains p) _ gone Q1). cbn [total] in Q2.
        unfold left', slack' in E0. lia.
      * destruct (IH gone' (count + 1) slack' left' most) as [M H]; auto; [subst slack'; lia|unfold left'; lia|].
        split; [exact M|].
        intros l1 x s l2 E K W. destruct (D _ _ _ _ E) as [(-> & -> & ->)|(l1' & -> & ->)].
        -- unfold joined. simpl. fold gone'. apply andb_false_iff in B. destruct B as [B|B].
           ++ apply Z.ltb_ge in B. unfold slack' in B. assert (T : saving (all_gains p) gone' <= most) by lia.
              eapply Z.le_trans; [exact T|exact M].
           ++ simpl in B. apply negb_false_iff, Z.eqb_eq in B. congruence.
        -- assert (Q := H l1' x s l2 eq_refl K). unfold joined in *. simpl. apply Q.
           cbn [app length] in W. rewrite Nat2Z.inj_succ in W. lia.
Qed.

Lemma top_gap_of_none all : top_gap all [] = top all.
Proof. destruct all; reflexivity. Qed.

Lemma scan_start p place c l most : Forall (sound n) l -> total reach l <= all_reach p ->
  most <= scan p (run_of place c l) [] 0 (most - top (all_gains p)) (all_reach p) most /\
  forall l1 x s l2, l = l1 ++ x :: s :: l2 -> key c x <> key c s ->
    leaf p <= Z.of_nat (length (l1 ++ [x])) <= size p - leaf p ->
    saving (all_gains p) (joined gains (l1 ++ [x]) [])
      <= scan p (run_of place c l) [] 0 (most - top (all_gains p)) (all_reach p) most.
Proof.
  intros S L. apply (scan_spec p place c l [] 0); auto. unfold saving. rewrite top_gap_of_none. simpl. lia.
Qed.

(** No cut of an order saves more. *)
Definition is_cap (p : part) (c : nat) (l : list sample) (most : Z) : Prop :=
  forall l1 x s l2, l = l1 ++ x :: s :: l2 -> key c x <> key c s ->
    leaf p <= Z.of_nat (length (l1 ++ [x])) <= size p - leaf p ->
    saving (all_gains p) (joined gains (l1 ++ [x]) []) <= most.

Variable place : sample -> Z.
Variable is_low : bool.

(** Parts before and after columns are counted: the same, but that more may be found. *)
Definition is_counted (what : counted -> counted -> Prop) (before after : list counted) : Prop :=
  Forall2 (fun b a => its_edge a = its_edge b /\ its_part a = its_part b /\ its_worst a = its_worst b /\
    found b <= found a /\ what b a) before after.

Definition caps (c : nat) (l : list sample) (b a : counted) : Prop :=
  is_cap (its_part b) c (part_of place (its_edge b) is_low l) (found a).

Definition lies_in (edge next : Z) : Prop := if is_low then next <= edge else edge <= next.

Lemma lies_in_part edge next l : lies_in edge next ->
  part_of place next is_low (part_of place edge is_low l) = part_of place next is_low l.
Proof.
  unfold lies_in, part_of. intros N. apply filter_filter. intros s. unfold is_in.
  destruct is_low; destruct (Z.leb_spec (place s) edge), (Z.leb_spec (place s) next); simpl; auto; lia.
Qed.

(** Each edge lies in the part of the one before. *)
Fixpoint nested (previous : option Z) (edges : list Z) : Prop :=
  match edges with
  | [] => True
  | edge :: rest => match previous with None => True | Some e => lies_in e edge end /\ nested (Some edge) rest
  end.

Lemma are_nested_spec : forall edges, are_nested is_low edges = true -> nested None edges.
Proof.
  assert (H : forall edges e, are_nested is_low (e :: edges) = true -> nested (Some e) edges).
  { induction edges as [|next edges IH]; intros e H; [exact I|]. change (are_nested is_low (e :: next :: edges))
      with ((if is_low then next <=? e else e <=? next) && are_nested is_low (next :: edges)) in H.
    apply andb_true_iff in H. destruct H as [H0 H1]. split; [|apply IH, H1].
    unfold lies_in. destruct is_low; apply Z.leb_le, H0. }
  intros [|e edges] N; [exact I|]. split; [exact I|]. apply H, N.
Qed.

Definition so_far (previous : option Z) (l : list sample) : list sample :=
  match previous with None => l | Some e => part_of place e is_low l end.

Lemma so_far_part previous edge l : match previous with None => True | Some e => lies_in e edge end ->
  part_of place edge is_low (so_far previous l) = part_of place edge is_low l.
Proof. destruct previous as [e|]; intros N; [apply lies_in_part, N|reflexivity]. Qed.

Lemma sound_part (keep : sample -> bool) l : Forall (sound n) l -> Forall (sound n) (filter keep l).
Proof. rewrite !Forall_forall. intros S s I. apply filter_In in I. apply S. tauto. Qed.

(** The sums of a part are those of these samples. *)
Definition describes (b : counted) (l : list sample) : Prop :=
  total reach (part_of place (its_edge b) is_low l) <= all_reach (its_part b).

Lemma scan_parts_spec c l : Forall (sound n) l -> forall parts previous, nested previous (map its_edge parts) ->
  Forall (fun b => describes b l) parts ->
  is_counted (caps c l) parts (scan_parts is_low parts (run_of place c (so_far previous l))).
Proof.
  intros S. induction parts as [|b parts IH]; intros previous N DS; simpl; [constructor|].
  inversion DS as [|? ? D0 D1]; subst.
  destruct N as [N0 N]. rewrite keep_run, so_far_part by exact N0. constructor.
  - destruct (scan_start (its_part b) place c (part_of place (its_edge b) is_low l) (found b) (sound_part _ _ S) D0) as [M H].
    simpl. repeat split; auto.
  - apply (IH (Some (its_edge b))); [exact N|exact D1].
Qed.

Lemma fold_parts_spec : forall (orders : list (nat * list sample)) parts,
  Forall (fun o => Forall (sound n) (snd o)) orders -> nested None (map its_edge parts) ->
  Forall (fun o => Forall (fun b => describes b (snd o)) parts) orders ->
  is_counted (fun b a => forall c l, In (c, l) orders -> caps c l b a) parts
    (fold_left (scan_parts is_low) (map (fun o => run_of place (fst o) (snd o)) orders) parts).
Proof.
  induction orders as [|[c l] orders IH]; intros parts S N DS; simpl.
  - clear. induction parts; constructor; auto. repeat split; auto; [lia|simpl; tauto].
  - inversion S as [|? ? S0 S1]; subst. simpl in S0.
    inversion DS as [|? ? D0 D1]; subst. simpl in D0.
    assert (A := scan_parts_spec c l S0 parts None N D0). simpl in A.
    set (parts' := scan_parts is_low parts (run_of place c l)) in *.
    assert (E : map its_edge parts' = map its_edge parts).
    { clear -A. induction A as [|b a bs as_ (E & _) F IH]; simpl; congruence. }
    assert (DS' : Forall (fun o => Forall (fun b => describes b (snd o)) parts') orders).
    { clear -A D1. rewrite Forall_forall in *. intros o I. specialize (D1 o I). clear -A D1.
      induction A as [|b a bs as_ (E1 & E2 & _) F IH]; [constructor|]. inversion D1; subst. constructor; auto.
      unfold describes in *. rewrite E1, E2. assumption. }
    assert (B := IH parts' S1 ltac:(rewrite E; exact N) DS'). clear -A B.
    set (last_ := fold_left _ _ _) in *. clearbody last_ parts'.
    revert last_ B. induction A as [|b a bs as_ (E1 & E2 & E3 & M & H) F IH']; intros last_ B; inversion B as [|? z ? zs Q T]; subst; constructor.
    + destruct Q as (G1 & G2 & G3 & M' & H'). rewrite G1, G2, G3, E1, E2, E3. repeat split; auto; [lia|].
      intros c' l' [X|X].
      * injection X as <- <-. unfold caps, is_cap in *. intros l1 x s l2 L K W.
        eapply Z.le_trans; [eapply H; eauto|exact M'].
      * specialize (H' c' l' X). unfold caps in *. rewrite E1, E2 in H'. exact H'.
    + apply IH', T.
Qed.

End Gains.

(** * Bounds *)

Section Rules.
Variable r : rules.
Hypothesis penalty_nonneg : 0 <= penalty r.
Hypothesis leaf_size_pos : (1 <= leaf_size r)%nat.

(** Orders of all columns that may be read. *)
Definition all_orders (samples : list sample) (orders : list (nat * list sample)) : Prop :=
  Forall (fun o => Permutation samples (snd o) /\ StronglySorted (key_le (fst o)) (snd o)) orders /\
  forall c, may_read r c = true -> exists l, In (c, l) orders.

Lemma paid_leaf a l : all_sound r l -> (a < n_labels r)%nat ->
  paid (Leaf a) l = total worst l - nth a (joined gains l []) 0.
Proof.
  intros S A. rewrite nth_joined, nth_nil. unfold paid. simpl.
  replace (0 + total (fun s => nth a (gains s) 0) l) with (total (fun s => gain a s) l) by (unfold gain; lia).
  rewrite <- total_minus. apply total_ext. intros s I. unfold all_sound in S. rewrite Forall_forall in S.
  apply (price_gain _ _ (S s I)). exact A.
Qed.

Lemma leaf_cost l b : all_sound r l -> b <= total worst l - top (joined gains l []) -> leaf_bounds r l b.
Proof.
  intros S B a A. rewrite paid_leaf by auto. assert (H := nth_le_top (joined gains l []) a). lia.
Qed.

Lemma bounds_of_leaf l b : leaf_bounds r l b -> bounds r 0 l b.
Proof.
  intros B t T D F. destruct t; simpl in D; [|lia]. unfold cost. simpl n_splits. rewrite Z.mul_0_r.
  apply B. destruct T as [_ T]. inversion T; auto.
Qed.

Lemma joined_nonneg l i : all_sound r l -> 0 <= nth i (joined gains l []) 0.
Proof.
  intros S. rewrite nth_joined, nth_nil.
  assert (0 <= total (fun s => nth i (gains s) 0) l); [|lia].
  apply total_nonneg. intros s I. unfold all_sound in S. rewrite Forall_forall in S.
  apply (gain_range _ _ (S s I)).
Qed.

Lemma saving_of_parts l low up : all_sound r l -> Permutation l (low ++ up) ->
  top (joined gains low []) + top (joined gains up []) <= saving (joined gains l []) (joined gains low []).
Proof.
  intros S P. unfold saving. apply Z.add_le_mono_l.
  assert (S' : all_sound r (low ++ up)) by (unfold all_sound in *; eapply Permutation_Forall; eauto).
  assert (SL : all_sound r low) by (unfold all_sound in *; apply Forall_app in S'; tauto).
  assert (SU : all_sound r up) by (unfold all_sound in *; apply Forall_app in S'; tauto).
  assert (E : forall i, nth i (joined gains l []) 0 = nth i (joined gains low []) 0 + nth i (joined gains up []) 0).
  { intros i. rewrite !nth_joined, !nth_nil. rewrite (total_perm _ _ _ P), total_app. lia. }
  apply top_le; [apply top_gap_nonneg|]. intros i.
  destruct (Nat.lt_ge_cases i (length (joined gains l []))) as [L|L].
  - assert (H := nth_le_top_gap (joined gains l []) (joined gains low []) i L). specialize (E i). lia.
  - specialize (E i). rewrite nth_overflow in E by lia. assert (A := joined_nonneg low i SL).
    assert (B := joined_nonneg up i SU). assert (C := top_gap_nonneg (joined gains l []) (joined gains low [])). lia.
Qed.

Lemma sound_perm l l' : Permutation l l' -> all_sound r l -> all_sound r l'.
Proof. intros P S. unfold all_sound in *. eapply Permutation_Forall; eauto. Qed.

Theorem one_part l orders most : all_sound r l -> all_orders l orders ->
  let p := Part (joined gains l []) (total reach l) (Z.of_nat (length l)) (Z.of_nat (leaf_size r)) in
  top (joined gains l []) + penalty r <= most -> (forall c o, In (c, o) orders -> is_cap p c o most) ->
  bounds r 1 l (total worst l + penalty r - most).
Proof.
  intros S [O R] p M H.
  apply node.
  - apply leaf_cost; auto. lia.
  - intros c th C W1 W2. destruct (R c C) as (o & I).
    rewrite Forall_forall in O. destruct (O _ I) as [P SS]. simpl in P, SS.
    assert (PL : Permutation (lower c th o) (lower c th l)) by (apply Permutation_sym, filter_perm, P).
    assert (PU : Permutation (upper c th o) (upper c th l)) by (apply Permutation_sym, filter_perm, P).
    assert (E := sorted_parts c th o SS).
    assert (So : all_sound r o) by (eapply sound_perm; eauto).
    assert (SP : all_sound r (lower c th o ++ upper c th o)) by (rewrite <- E; exact So).
    assert (SL : all_sound r (lower c th o)) by (unfold all_sound in *; apply Forall_app in SP; tauto).
    assert (SU : all_sound r (upper c th o)) by (unfold all_sound in *; apply Forall_app in SP; tauto).
    assert (NL := Permutation_length PL). assert (NU := Permutation_length PU).
    assert (NE := Permutation_length P). rewrite E, app_length in NE.
    exists (total worst (lower c th o) - top (joined gains (lower c th o) [])),
           (total worst (upper c th o) - top (joined gains (upper c th o) [])).
    split; [eapply bounds_perm; [exact PL|]; apply bounds_of_leaf, leaf_cost; [exact SL|lia]|].
    split; [eapply bounds_perm; [exact PU|]; apply bounds_of_leaf, leaf_cost; [exact SU|lia]|].
    assert (SV := saving_of_parts l (lower c th o) (upper c th o) S).
    assert (P' : Permutation l (lower c th o ++ upper c th o)) by (rewrite <- E; exact P).
    specialize (SV P').
    assert (W : total worst l = total worst (lower c th o) + total worst (upper c th o))
      by (rewrite (total_perm _ _ _ P'), total_app; reflexivity).
    destruct (exists_last (l := lower c th o)) as (l1 & x & EL); [intros Z0; rewrite Z0 in NL; simpl in NL; lia|].
    destruct (upper c th o) as [|s l2] eqn:EU; [simpl in NU; lia|].
    assert (X := lower_keys c th o x). rewrite EL in X. specialize (X (in_elt _ _ _)).
    assert (Y := upper_keys c th o s). rewrite EU in Y. specialize (Y (or_introl eq_refl)).
    assert (F : saving (all_gains p) (joined gains (l1 ++ [x]) []) <= most).
    { apply (H c o I l1 x s l2).
      - rewrite E at 1. rewrite EL, <- app_assoc. reflexivity.
      - lia.
      - rewrite <- EL. simpl. simpl length in NU, NE. lia. }
    rewrite <- EL in F. simpl all_gains in F. lia.
Qed.

Definition orders_of (f : list sample -> list sample) (orders : list (nat * list sample)) :=
  map (fun o => (fst o, f (snd o))) orders.

Lemma all_orders_part keep l orders : all_orders l orders -> all_orders (filter keep l) (orders_of (filter keep) orders).
Proof.
  intros [O R]. split.
  - rewrite Forall_forall in *. intros o I. apply in_map_iff in I. destruct I as (o' & <- & I). simpl.
    destruct (O o' I). split; [apply filter_perm; auto|apply sorted_filter; auto].
  - intros c C. destruct (R c C) as (o & I). exists (filter keep o). apply in_map_iff. exists (c, o). auto.
Qed.

Lemma sound_filter keep l : all_sound r l -> all_sound r (filter keep l).
Proof.
  unfold all_sound. rewrite !Forall_forall. intros S s I. apply filter_In in I. apply S. tauto.
Qed.

Lemma parts_of_spec place is_low samples : all_sound r samples -> forall edges previous,
  nested is_low previous edges ->
  Forall2 (fun edge c => let kept := part_of place edge is_low samples in
    its_edge c = edge /\ its_worst c = total worst kept /\ found c = top (joined gains kept []) + penalty r /\
    its_part c = Part (joined gains kept []) (total reach kept) (Z.of_nat (length kept)) (Z.of_nat (leaf_size r))) edges
    (parts_of (penalty r) (Z.of_nat (leaf_size r)) place is_low edges (so_far place is_low previous samples)).
Proof.
  intros S. induction edges as [|edge edges IH]; intros previous N; cbn [parts_of]; [constructor|].
  destruct N as [N0 N]. rewrite so_far_part by exact N0. rewrite sums_spec, !Z.add_0_l. constructor.
  - simpl. auto.
  - apply (IH (Some edge)), N.
Qed.

(** All parts that are counted are bounded. *)
Theorem stumps_spec place is_low samples orders edges : all_sound r samples -> all_orders samples orders ->
  Forall2 (fun edge b => bounds r 1 (part_of place edge is_low samples) b) edges
    (stumps (penalty r) (Z.of_nat (leaf_size r)) place is_low edges samples
      (map (fun o => run_of place (fst o) (snd o)) orders)).
Proof.
  intros S O. unfold stumps. destruct (are_nested is_low edges) eqn:N.
  - apply are_nested_spec in N.
    assert (OS : Forall (fun o => Forall (sound (n_labels r)) (snd o)) orders).
    { destruct O as [O _]. rewrite Forall_forall in O |- *. intros o I. apply (sound_perm samples (snd o)); [apply O, I|exact S]. }
    assert (A := parts_of_spec place is_low samples S edges None N). simpl in A.
    set (parts := parts_of _ _ place is_low edges samples) in *.
    assert (E : map its_edge parts = edges).
    { clear -A. induction A as [|e c es cs (E & _) F IH]; simpl; congruence. }
    assert (DS : Forall (fun o => Forall (fun b => describes place is_low b (snd o)) parts) orders).
    { destruct O as [O _]. rewrite Forall_forall in O |- *. intros o I. destruct (O o I) as [P _]. clear -A P.
      induction A as [|e c es cs (E1 & _ & _ & E4) F IH]; constructor; auto.
      unfold describes. rewrite E4, E1. simpl. apply Z.eq_le_incl, total_perm, filter_perm, Permutation_sym, P. }
    assert (B := fold_parts_spec (n_labels r) place is_low orders parts OS ltac:(rewrite E; exact N) DS).
    set (parts' := fold_left _ _ _) in *. clearbody parts'. clear E N DS. clearbody parts.
    revert parts' B. induction A as [|e c es cs (E1 & E2 & E3 & E4) F IH]; intros parts' B; inversion B as [|? c' ? cs' Q T]; subst;
      simpl; constructor; [|apply IH, T].
    destruct Q as (G1 & G2 & G3 & M & H). rewrite G3, E2.
    apply (one_part _ (orders_of (part_of place (its_edge c) is_low) orders)).
    + apply sound_filter, S.
    + apply all_orders_part, O.
    + rewrite <- E3. exact M.
    + intros i o I. apply in_map_iff in I. destruct I as ([i' l] & X & I). injection X as <- <-.
      specialize (H i' l I). unfold caps in H. rewrite E4 in H. exact H.
  - clear N. induction edges as [|edge edges IH]; simpl; constructor; auto.
    apply bounds_zero; [exact penalty_nonneg|]. apply sound_filter, S.
Qed.

End Rules.
