(** What samples cost at least by the labels that a tree may give: by label, and by sets of labels. *)

From Coq Require Import ZArith List Bool Permutation Lia Arith.
Import ListNotations.
From octmip Require Import Samples Sums Trees Inequalities Sides.
Open Scope Z_scope.
Local Arguments Z.add : simpl never.
Local Arguments Z.sub : simpl never.
Local Arguments Z.mul : simpl never.

(** * By label *)

Lemma nth_leave_out x : forall sums previous i, (i < length sums)%nat ->
  nth i (leave_out x previous sums) 0 = Z.min (x + nth i sums 0) (nth i (previous :: sums) 0).
Proof.
  induction sums as [|y sums IH]; intros previous i L; simpl in L; [lia|].
  destruct i; [reflexivity|]. simpl leave_out. simpl nth at 1 2. rewrite IH by lia. reflexivity.
Qed.

Lemma leave_out_length x : forall sums previous, length (leave_out x previous sums) = length sums.
Proof. induction sums; simpl; auto. Qed.

Lemma least_sums_length zeros v : length (least_sums zeros v) = length zeros.
Proof.
  induction v as [|x v IH]; simpl; [reflexivity|].
  destruct (least_sums zeros v) as [|y rest]; simpl in *; [auto|]. rewrite leave_out_length. exact IH.
Qed.

Lemma beyond_first_length places :
  (length (beyond_first places) + (if has places 0 then 1 else 0) <= length places)%nat.
Proof.
  unfold beyond_first, has. rewrite map_length. induction places as [|p places IH]; [simpl; lia|].
  cbn [existsb filter]. destruct (Nat.eqb_spec 0 p) as [<-|N].
  - cbn [Nat.eqb negb orb length]. destruct (existsb (Nat.eqb 0) places); lia.
  - destruct (Nat.eqb_spec p 0); [congruence|]. cbn [negb orb length].
    destruct (existsb (Nat.eqb 0) places); lia.
Qed.

Lemma least_sums_le c v : forall places i, (length places <= i)%nat -> (i <= c)%nat ->
  nth i (least_sums (repeat 0 (S c)) v) 0 <= outside places v.
Proof.
  induction v as [|x v IH]; intros places i L C.
  - cbn [least_sums outside]. rewrite nth_repeat. lia.
  - cbn [least_sums outside]. assert (N := least_sums_length (repeat 0 (S c)) v). rewrite repeat_length in N.
    assert (B := beyond_first_length places).
    destruct (least_sums (repeat 0 (S c)) v) as [|y rest] eqn:E; [discriminate|]. simpl in N.
    destruct i.
    + assert (places = []) by (destruct places; [auto|simpl in L; lia]). subst.
      simpl. apply Z.add_le_mono_l. apply (IH [] 0%nat); lia.
    + cbn [nth]. rewrite nth_leave_out by lia.
      destruct (has places 0).
      * assert (H := IH (beyond_first places) i). lia.
      * assert (H := IH (beyond_first places) (S i)). cbn [nth] in H. lia.
Qed.

Lemma last_nth (l : list Z) d : l <> [] -> last l d = nth (length l - 1) l d.
Proof.
  induction l as [|x l IH]; intros H; [congruence|]. destruct l as [|y l]; [reflexivity|].
  change (last (x :: y :: l) d) with (last (y :: l) d). rewrite IH by discriminate.
  simpl length. replace (S (S (length l)) - 1)%nat with (S (S (length l) - 1)) by lia. reflexivity.
Qed.

Lemma outside_mono v : Forall (fun x => 0 <= x) v -> forall few many,
  (forall place, has few place = true -> has many place = true) -> outside many v <= outside few v.
Proof.
  induction 1 as [|x v P H IH]; intros few many Sub; simpl; [lia|].
  assert (G : outside (beyond_first many) v <= outside (beyond_first few) v).
  { apply IH. intros place. unfold has, beyond_first. rewrite !existsb_exists.
    intros (q & Q & E). apply in_map_iff in Q. destruct Q as (q' & Q' & I). apply filter_In in I.
    destruct I as [I N]. assert (T : has many (S place) = true).
    { apply Sub. unfold has. apply existsb_exists. exists q'. split; [exact I|].
      apply Nat.eqb_eq in E. destruct q'; [discriminate|]. simpl in Q'. apply Nat.eqb_eq. lia. }
    unfold has in T. apply existsb_exists in T. destruct T as (z & Z1 & Z2). exists (Nat.pred z).
    apply Nat.eqb_eq in Z2. split; [|apply Nat.eqb_eq; lia]. apply in_map_iff. exists z. split; [reflexivity|].
    apply filter_In. split; [exact Z1|]. subst. reflexivity. }
  assert (S0 := Sub 0%nat). destruct (has few 0), (has many 0); try lia.
Qed.

Lemma outside_nonneg v : Forall (fun x => 0 <= x) v -> forall places, 0 <= outside places v.
Proof.
  induction 1 as [|x v P H IH]; intros places; simpl; [lia|]. specialize (IH (beyond_first places)).
  destruct (has places 0); lia.
Qed.

Section Rules.
Variable r : rules.
Hypothesis penalty_nonneg : 0 <= penalty r.

Theorem spread_spec d m : all_sound r m ->
  spreads r d m (total sure m + spread (label_count (n_labels r) d) (joined more m [])).
Proof.
  intros S t T D. unfold all_sound in S. rewrite Forall_forall in S.
  assert (P : total sure m + outside (labels t) (joined more m []) <= paid t m).
  { rewrite outside_joined. cbn [outside]. replace (total sure m + (0 + _)) with
      (total (fun s => sure s - - outside (labels t) (more s)) m) by (rewrite total_minus;
      replace (total (fun s => - outside (labels t) (more s)) m) with
        (total (fun s => 0 - outside (labels t) (more s)) m) by (apply total_ext; intros; lia);
      rewrite total_minus; replace (total (fun _ => 0) m) with 0 by (clear; induction m; simpl; lia); lia).
    apply total_le. intros s I. assert (V := S s I).
    assert (A := price_more _ _ V _ (answer_legal _ _ t s T)).
    assert (B : outside (labels t) (more s) <= outside [answer t s] (more s)).
    { apply outside_mono; [apply (more_nonneg _ _ V)|]. intros place. rewrite has_one. intros E.
      apply Nat.eqb_eq in E. subst. apply existsb_exists. exists (answer t s). split; [apply answer_in|].
      apply Nat.eqb_refl. }
    lia. }
  assert (Q : spread (label_count (n_labels r) d) (joined more m []) <= outside (labels t) (joined more m [])).
  { unfold spread, label_count. destruct (Z.of_nat (n_labels r) <=? 2 ^ Z.of_nat d).
    - rewrite outside_joined. cbn [outside].
      assert (0 <= total (fun s => outside (labels t) (more s)) m).
      { apply total_nonneg. intros s I. apply outside_nonneg, (more_nonneg _ _ (S s I)). }
      lia.
    - assert (N := least_sums_length (repeat 0 (Datatypes.S (2 ^ d))) (joined more m [])).
      rewrite repeat_length in N.
      rewrite last_nth by (intros E; rewrite E in N; discriminate).
      rewrite N. replace (Datatypes.S (2 ^ d) - 1)%nat with (2 ^ d)%nat by lia.
      apply least_sums_le; [|lia]. assert (L := labels_length t).
      assert (2 ^ levels t <= 2 ^ d)%nat by (apply Nat.pow_le_mono_r; lia). lia. }
  lia.
Qed.

(** * Sets of labels *)

Lemma subsets_complete : forall labels size few, NoDup few -> incl few labels -> (length few <= size)%nat ->
  exists set, In set (subsets size labels) /\ incl few set.
Proof.
  induction labels as [|x labels IH]; intros size few D I L.
  - exists []. simpl. auto.
  - destruct size as [|size].
    + exists []. split; [simpl; auto|]. destruct few; [intros y []|simpl in L; lia].
    + cbn [subsets]. destruct (Nat.leb _ _); [exists (x :: labels); simpl; auto|].
      destruct (in_dec Nat.eq_dec x few) as [J|J].
      * destruct (in_split x few J) as (f1 & f2 & ->). assert (ND := NoDup_remove _ _ _ D). destruct ND as [D' N].
        destruct (IH size (f1 ++ f2) D') as (set & S & Q).
        { intros y Y. destruct (I y) as [<-|Z0]; [|contradiction|auto].
          apply in_app_or in Y. apply in_or_app. simpl. tauto. }
        { rewrite app_length in *. simpl in L. lia. }
        exists (x :: set). split; [apply in_or_app; right; apply in_map, S|].
        intros y Y. apply in_app_or in Y. destruct Y as [Y|[<-|Y]]; simpl; auto;
          right; apply Q, in_or_app; auto.
      * destruct (IH (S size) few D) as (set & S & Q); [|exact L|exists set; split; [apply in_or_app; auto|exact Q]].
        intros y Y. destruct (I y Y) as [<-|Z0]; [contradiction|exact Z0].
Qed.

Lemma label_sets_complete is_wanted d t : is_legal (n_labels r) (may_read r) t -> (levels t <= d)%nat ->
  label_sets is_wanted (n_labels r) d = [] \/
  exists set, In set (label_sets is_wanted (n_labels r) d) /\ incl (labels t) set.
Proof.
  intros [_ T] D. unfold label_sets, label_count. destruct (_ <=? _); [auto|]. destruct (_ && _); [right|auto].
  destruct (subsets_complete (seq 0 (n_labels r)) (2 ^ d) (nodup Nat.eq_dec (labels t))) as (set & S & Q).
  - apply NoDup_nodup.
  - intros y Y. apply nodup_In in Y. rewrite Forall_forall in T. apply in_seq. specialize (T y Y). lia.
  - assert (L := labels_length t). assert (2 ^ levels t <= 2 ^ d)%nat by (apply Nat.pow_le_mono_r; lia).
    assert (N := NoDup_incl_length (NoDup_nodup Nat.eq_dec (labels t))
      (fun y (Y : In y (nodup Nat.eq_dec (labels t))) => proj1 (nodup_In Nat.eq_dec (labels t) y) Y)). lia.
  - exists set. split; [exact S|]. intros y Y. apply Q, nodup_In, Y.
Qed.

Lemma least_in v x : In x v -> or_zero (least v) <= x.
Proof. intros I. destruct (In_nth _ _ 0 I) as (i & L & <-). apply least_spec, L. Qed.

Lemma set_costs_length sets s : length (set_costs sets s) = length sets.
Proof. apply map_length. Qed.

Lemma joined_set_costs sets m : m <> [] -> length (joined (set_costs sets) m []) = length sets.
Proof.
  assert (A : forall u v : list Z, length (add u v) = Nat.max (length u) (length v)).
  { induction u as [|x u IH]; intros [|y v]; simpl; auto. }
  destruct m as [|s m]; [congruence|]. intros _. unfold joined. cbn [fold_left].
  assert (H : length (add [] (set_costs sets s)) = length sets) by (rewrite A, set_costs_length; reflexivity).
  revert H. generalize (add [] (set_costs sets s)). induction m as [|s' m IH]; intros v H; [exact H|].
  apply IH. rewrite A, set_costs_length, H. lia.
Qed.

Theorem sets_spec d m is_wanted : all_sound r m ->
  spreads r d m (or_zero (least (joined (set_costs (label_sets is_wanted (n_labels r) d)) m []))).
Proof.
  intros S t T D. unfold all_sound in S. rewrite Forall_forall in S.
  assert (P : 0 <= paid t m).
  { apply total_nonneg. intros s I. apply (price_nonneg _ _ (S s I)), (answer_legal _ _ t s T). }
  destruct m as [|s0 m0]; [exact P|]. set (m := s0 :: m0) in *.
  assert (M : m <> []) by discriminate.
  destruct (label_sets_complete is_wanted d t T D) as [E|(set & I & Q)].
  - assert (L := joined_set_costs (label_sets is_wanted (n_labels r) d) m M). rewrite E in *.
    destruct (joined _ _ _); [exact P|discriminate].
  - set (sets := label_sets _ _ _) in *. destruct (In_nth _ _ [] I) as (i & L & E).
    assert (J := joined_set_costs sets m M).
    apply Z.le_trans with (nth i (joined (set_costs sets) m []) 0); [apply least_spec; lia|].
    rewrite nth_joined, nth_nil, Z.add_0_l. apply total_le. intros s K.
    unfold set_costs. set (f := fun set => or_zero (least (map (fun label => price label s) set))).
    rewrite nth_indep with (d' := f []) by (rewrite map_length; exact L). rewrite map_nth, E. apply least_in.
    apply (in_map (fun label => price label s)). apply Q, answer_in.
Qed.

Lemma spreads_max d m a b : spreads r d m a -> spreads r d m b -> spreads r d m (Z.max a b).
Proof. intros A B t T D. specialize (A t T D). specialize (B t T D). lia. Qed.

End Rules.
