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

(** No cut of the run saves more than what a scan returns. *)
Lemma scan_spec p place c : forall l gone count slack most,
  Forall (sound n) l -> saving (all_gains p) gone + slack <= most ->
  most <= scan p (run_of place c l) gone count slack most /\
  forall l1 x s l2, l = l1 ++ x :: s :: l2 -> key c x <> key c s ->
    leaf p <= count + Z.of_nat (length (l1 ++ [x])) <= size p - leaf p ->
    saving (all_gains p) (joined gains (l1 ++ [x]) gone) <= scan p (run_of place c l) gone count slack most.
Proof.
  induction l as [|y l IH]; intros gone count slack most S I.
  - split; [simpl; lia|]. intros l1 x s l2 E. destruct l1; discriminate.
  - inversion S as [|? ? S0 S1]; subst. cbn [run_of scan].
    assert (ST := saving_step y (all_gains p) gone S0).
    set (gone' := add gone (gains y)) in *. set (slack' := slack - reach y).
    assert (D : forall l1 x s l2, y :: l = l1 ++ x :: s :: l2 ->
      (l1 = [] /\ x = y /\ l = s :: l2) \/ (exists l1', l1 = y :: l1' /\ l = l1' ++ x :: s :: l2)).
    { intros l1 x s l2 E. destruct l1 as [|z l1]; injection E; intros; subst; [left; auto|right; eauto]. }
    destruct ((slack' <? 0) && differs (key c y) (run_of place c l)) eqn:B.
    + set (saved := top gone' + top_gap (all_gains p) gone').
      set (wide := (leaf p <=? count + 1) && (count + 1 <=? size p - leaf p)).
      set (most' := if wide then Z.max most saved else most).
      destruct (IH gone' (count + 1) (most' - saved) most') as [M H]; auto; [change (saved + (most' - saved) <= most'); rewrite Zplus_minus; apply Z.le_refl|].
      split; [subst most'; destruct wide; lia|].
      intros l1 x s l2 E K W. destruct (D _ _ _ _ E) as [(-> & -> & ->)|(l1' & -> & ->)].
      * unfold joined. simpl. fold gone'. simpl in W. assert (Wide : wide = true).
        { subst wide. apply andb_true_iff. rewrite !Z.leb_le. lia. }
        apply Z.le_trans with most'; [|exact M]. unfold most'. rewrite Wide.
        change (saved <= Z.max most saved). apply Z.le_max_r.
      * assert (Q := H l1' x s l2 eq_refl K). unfold joined in *. simpl. apply Q.
        cbn [app length] in W. rewrite Nat2Z.inj_succ in W. lia.
    + destruct (IH gone' (count + 1) slack' most) as [M H]; auto; [subst slack'; lia|].
      split; [exact M|].
      intros l1 x s l2 E K W. destruct (D _ _ _ _ E) as [(-> & -> & ->)|(l1' & -> & ->)].
      * unfold joined. simpl. fold gone'. apply andb_false_iff in B. destruct B as [B|B].
        -- apply Z.ltb_ge in B. unfold slack' in B. assert (saving (all_gains p) gone' <= most) by lia.
           eapply Z.le_trans; [exact H0|exact M].
        -- simpl in B. apply negb_false_iff, Z.eqb_eq in B. congruence.
      * assert (Q := H l1' x s l2 eq_refl K). unfold joined in *. simpl. apply Q.
        cbn [app length] in W. rewrite Nat2Z.inj_succ in W. lia.
Qed.

Lemma top_gap_of_none all : top_gap all [] = top all.
Proof. destruct all; reflexivity. Qed.

Lemma scan_start p place c l most : Forall (sound n) l ->
  most <= scan p (run_of place c l) [] 0 (most - top (all_gains p)) most /\
  forall l1 x s l2, l = l1 ++ x :: s :: l2 -> key c x <> key c s ->
    leaf p <= Z.of_nat (length (l1 ++ [x])) <= size p - leaf p ->
    saving (all_gains p) (joined gains (l1 ++ [x]) [])
      <= scan p (run_of place c l) [] 0 (most - top (all_gains p)) most.
Proof.
  intros S. apply (scan_spec p place c l [] 0); auto. unfold saving. rewrite top_gap_of_none. simpl. lia.
Qed.

Lemma scan_all_spec p place : forall (orders : list (nat * list sample)) most,
  Forall (fun o => Forall (sound n) (snd o)) orders ->
  let found := scan_all p (map (fun o => run_of place (fst o) (snd o)) orders) most in
  most <= found /\
  forall c l, In (c, l) orders -> forall l1 x s l2, l = l1 ++ x :: s :: l2 -> key c x <> key c s ->
    leaf p <= Z.of_nat (length (l1 ++ [x])) <= size p - leaf p ->
    saving (all_gains p) (joined gains (l1 ++ [x]) []) <= found.
Proof.
  induction orders as [|[c l] orders IH]; intros most S; simpl; [split; [lia|tauto]|].
  inversion S as [|? ? S0 S1]; subst. simpl in S0.
  destruct (scan_start p place c l most S0) as [M H].
  destruct (IH (scan p (run_of place c l) [] 0 (most - top (all_gains p)) most) S1) as [M' H'].
  split; [lia|]. intros c' l' [E|I] l1 x s l2 L K W.
  - injection E as <- <-. eapply Z.le_trans; [|exact M']. eapply H; eauto.
  - eapply H'; eauto.
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

Theorem one_part place l orders : all_sound r l -> all_orders l orders ->
  let p := Part (joined gains l []) (Z.of_nat (length l)) (Z.of_nat (leaf_size r)) in
  bounds r 1 l (total worst l + penalty r -
    scan_all p (map (fun o => run_of place (fst o) (snd o)) orders) (top (joined gains l []) + penalty r)).
Proof.
  intros S [O R] p.
  assert (OS : Forall (fun o => Forall (sound (n_labels r)) (snd o)) orders).
  { rewrite Forall_forall in O |- *. intros o I. apply (sound_perm l (snd o)); [apply O, I|exact S]. }
  destruct (scan_all_spec (n_labels r) p place orders (top (joined gains l []) + penalty r) OS) as [M H].
  set (found := scan_all _ _ _) in *.
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
    assert (F : saving (all_gains p) (joined gains (l1 ++ [x]) []) <= found).
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

Definition so_far (place : sample -> Z) (is_low : bool) (previous : option Z) (l : list sample) : list sample :=
  match previous with None => l | Some e => part_of place e is_low l end.

Lemma so_far_part place is_low previous edge l : is_nested is_low previous edge = true ->
  part_of place edge is_low (so_far place is_low previous l) = part_of place edge is_low l.
Proof.
  intros N. destruct previous as [e|]; [|reflexivity]. simpl in *. unfold part_of. apply filter_filter.
  intros s. unfold is_in. destruct is_low; apply Z.leb_le in N;
    destruct (Z.leb_spec (place s) edge), (Z.leb_spec (place s) e); simpl; auto; lia.
Qed.

(** All parts that are counted are bounded. *)
Theorem stumps_spec place is_low samples orders : all_sound r samples -> all_orders samples orders ->
  forall edges previous,
  Forall2 (fun edge b => bounds r 1 (part_of place edge is_low samples) b) edges
    (stumps (penalty r) (Z.of_nat (leaf_size r)) place is_low edges previous
      (so_far place is_low previous samples)
      (map (fun o => run_of place (fst o) (snd o)) (orders_of (so_far place is_low previous) orders))).
Proof.
  intros S O. induction edges as [|edge edges IH]; intros previous; cbn [stumps]; [constructor|].
  destruct (is_nested is_low previous edge) eqn:N.
  - rewrite so_far_part by exact N. rewrite sums_spec. rewrite !Z.add_0_l.
    assert (E : map (keep edge is_low)
        (map (fun o => run_of place (fst o) (snd o)) (orders_of (so_far place is_low previous) orders)) =
      map (fun o => run_of place (fst o) (snd o)) (orders_of (part_of place edge is_low) orders)).
    { unfold orders_of. rewrite !map_map. apply map_ext. intros o. simpl. rewrite keep_run, so_far_part by exact N.
      reflexivity. }
    rewrite E. constructor.
    + apply one_part; [apply sound_filter, S|apply all_orders_part, O].
    + apply (IH (Some edge)).
  - constructor; [|apply IH]. apply bounds_zero; [exact penalty_nonneg|]. apply sound_filter, S.
Qed.

End Rules.
