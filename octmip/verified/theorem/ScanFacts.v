(** A scan finds the most that a cut saves: orders, sums along them, and the walk that skips. *)

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
    cbn [total] in LE. set (gone' := add gone (gains y)) in *. set (slack' := slack - reach y).
      set (left' := left - reach y).
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
        { rewrite E. replace (l1 ++ x :: s :: l2) with ((l1 ++ [x]) ++ s :: l2) in * by (rewrite <- app_assoc;
          reflexivity).
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
  - destruct (scan_start (its_part b) place c (part_of place (its_edge b) is_low l) (found b) (sound_part _ _ S) D0)
    as [M H].
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
    revert last_ B. induction A as [|b a bs as_ (E1 & E2 & E3 & M & H) F IH']; intros last_ B;
      inversion B as [|? z ? zs Q T]; subst; constructor.
    + destruct Q as (G1 & G2 & G3 & M' & H'). rewrite G1, G2, G3, E1, E2, E3. repeat split; auto; [lia|].
      intros c' l' [X|X].
      * injection X as <- <-. unfold caps, is_cap in *. intros l1 x s l2 L K W.
        eapply Z.le_trans; [eapply H; eauto|exact M'].
      * specialize (H' c' l' X). unfold caps in *. rewrite E1, E2 in H'. exact H'.
    + apply IH', T.
Qed.

End Gains.
