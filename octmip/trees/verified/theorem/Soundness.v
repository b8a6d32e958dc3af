(** The theorem: what the checker accepts is true of every tree that is asked for. *)

From Coq Require Import ZArith List Bool Permutation Sorting.Sorted Sorting.Mergesort Lia Arith.
Import ListNotations.
From octmip Require Import Specification Samples Sums Trees Inequalities Columns Checker ColumnFacts BlockFacts.
From octmip Require Import StumpFacts Whole Cases.
From octmip Require Import NodeFacts QuestionFacts BudgetFacts.
Open Scope Z_scope.
Local Arguments Z.add : simpl never.
Local Arguments Z.sub : simpl never.
Local Arguments Z.mul : simpl never.

(** * Samples in the order of a column *)

Lemma sorted_perm c l : Permutation l (sorted c l).
Proof.
  unfold sorted. assert (P := KeySort.Permuted_sort (map (fun s => (key c s, s)) l)).
  apply (Permutation_map snd) in P. rewrite map_map in P. simpl in P. rewrite map_id in P. exact P.
Qed.

Lemma sorted_sorted c l : StronglySorted (key_le c) (sorted c l).
Proof.
  unfold sorted. set (pairs := map (fun s => (key c s, s)) l).
  assert (T : forall x y z, KeyOrder.leb x y = true -> KeyOrder.leb y z = true -> KeyOrder.leb x z = true).
  { unfold KeyOrder.leb. intros x y z A B. apply Z.leb_le in A, B. apply Z.leb_le. lia. }
  assert (SS := KeySort.StronglySorted_sort pairs T).
  assert (K : Forall (fun o => fst o = key c (snd o)) (KeySort.sort pairs)).
  { eapply Permutation_Forall; [apply KeySort.Permuted_sort|]. unfold pairs. rewrite Forall_forall. intros o I.
    apply in_map_iff in I. destruct I as (s & <- & _). reflexivity. }
  induction SS as [|o os SS IH F]; simpl; [constructor|]. inversion K as [|? ? K0 K1]; subst.
    constructor; [apply IH, K1|].
  rewrite Forall_forall in *. intros s I. apply in_map_iff in I. destruct I as (o' & <- & I).
  specialize (F o' I). unfold KeyOrder.leb in F. apply Z.leb_le in F. unfold key_le. rewrite <- K0, <- (K1 o' I).
    exact F.
Qed.

(** * The cases of a log *)

Section Question.
Variable q : question.
Variable w : numbers.

Local Notation all := (@QuestionFacts.all q).
Local Notation matches := (@QuestionFacts.matches q w).
Local Notation stands_for := (@QuestionFacts.stands_for q).
Local Notation keeps_to := (@BudgetFacts.keeps_to q).

Lemma fresh_in_play ds samples :
  is_fresh (rules_of q w ds all) samples (columns_in_play q ds all samples).
Proof.
  split.
  - rewrite Forall_forall. intros c I. apply in_map_iff in I. destruct I as (i & <- & _).
    split; [split; [apply sorted_perm|apply sorted_sorted]|reflexivity].
  - intros c R. exists (unsolved c (sorted c samples)). split; [|reflexivity].
    apply in_map_iff. exists c. split; [reflexivity|]. apply filter_In. split; [|exact R].
    simpl in R. unfold may_read_column in R. apply in_seq. split; [lia|]. simpl.
    destruct (nth_error all c) eqn:E; [|discriminate]. apply nth_error_Some. congruence.
Qed.

Section Log.
Variable samples : list sample.
Hypothesis their_samples : Forall2 matches (rows q) samples.
Hypothesis proper : is_proper q = true.
Hypothesis penalty_pos : 0 <= its_penalty w.

Lemma proper_fewest : (1 <= fewest q)%nat.
Proof. unfold is_proper in proper. rewrite !andb_true_iff, Nat.leb_le in proper. tauto. Qed.
Lemma proper_costs : Forall (fun c => 0 <= c) (sensor_costs q).
Proof.
  unfold is_proper in proper. rewrite !andb_true_iff, forallb_forall in proper. rewrite Forall_forall. intros c I.
  apply Z.leb_le, proper, I.
Qed.
Lemma proper_features f : nth f (allowed q) false = true -> (f < length (sensors q))%nat.
Proof.
  unfold is_proper in proper. rewrite !andb_true_iff, !Nat.leb_le in proper. intros A.
  destruct (Nat.lt_ge_cases f (length (allowed q))) as [L|L]; [lia|]. rewrite nth_overflow in A by exact L.
    discriminate.
Qed.

Lemma samples_sound : Forall (sound (n_classes q)) samples.
Proof.
  generalize their_samples. clear. generalize (rows q) as xs. intros xs F.
    induction F as [|x s xs ss M F IH]; constructor; auto.
  apply (its_sound x s M).
Qed.

Lemma case_spec t t' ds proof bound : is_asked_for q t -> stands_for t t' -> NoDup (map fst ds) -> keeps_to t ds ->
  check_node (rules_of q w ds all) (depth q) samples (columns_in_play q ds all samples) proof = Ok bound ->
  bound <= cost (its_penalty w) t' samples.
Proof.
  intros (D & L & A & F & W) T ND K H.
  assert (B := check_node_spec (rules_of q w ds all) penalty_pos proper_fewest (depth q) samples _ proof bound
    samples_sound (fresh_in_play ds samples) H).
  destruct (stands_shape t t' T) as (SL & SS & SA).
  apply B.
  - split; [|simpl; rewrite SA; exact L]. rewrite Forall_forall in *. intros c I.
    destruct (stands_columns t t' T c I) as (f & fill & IF & E). simpl. unfold may_read_column. rewrite E.
    unfold may_read_place. simpl. apply andb_true_iff. split; [apply A, IF|].
    apply (may_read_what_is_read t); auto; [apply proper_costs|apply reads_feature, IF].
  - rewrite SL. exact D.
  - destruct F as [[a ->]|F]; [left; exists a; inversion T; reflexivity|right].
    eapply stands_leaves; eauto. apply incl_refl.
Qed.

Lemma check_cases_spec claim t t' : is_asked_for q t -> stands_for t t' -> forall log ds b,
  NoDup (map fst ds) -> keeps_to t ds ->
  check_cases q w all samples claim ds log = Ok b -> claim <= cost (its_penalty w) t' samples.
Proof.
  intros A T. induction log as [proof|line sensor unread IHU read IHR|line]; intros ds b N K H; simpl in H;
    [| |discriminate].
  - destruct (check_node _ _ _ _ proof) as [bound|] eqn:E; [|discriminate]. unfold ensure in H.
    destruct (Z.leb_spec claim bound) as [L|]; [|discriminate].
    assert (B := case_spec t t' ds proof bound A T N K E). lia.
  - destruct ((0 <=? sensor) && (sensor <? Z.of_nat (length (sensor_costs q))) &&
      match decided (Z.to_nat sensor) ds with None => true | Some _ => false end) eqn:E; [|discriminate].
    apply andb_true_iff in E. destruct E as [_ E].
    destruct (decided (Z.to_nat sensor) ds) eqn:DS; [discriminate|]. assert (NI := decided_none _ _ DS).
    destruct (check_cases q w all samples claim ((Z.to_nat sensor,
      false) :: ds) unread) as [b'|] eqn:U; [|discriminate].
    assert (ND : forall v : bool, NoDup (map fst ((Z.to_nat sensor, v) :: ds))) by (intros v; simpl; constructor; auto).
    assert (KT : keeps_to t ((Z.to_nat sensor, reads q t (Z.to_nat sensor)) :: ds)).
    { intros s v [X|X]; [injection X as <- <-; reflexivity|apply K, X]. }
    destruct (reads q t (Z.to_nat sensor)); [apply (IHR _ b (ND true) KT H)|apply (IHU _ b' (ND false) KT U)].
Qed.

End Log.

(** ** The theorem *)

(** If the checker accepts a log, then no tree that is asked for costs less than the bound that it returns. The bound is
    in units of [1 / down w] of the question's costs. *)
Theorem accepted_bounds_hold claim log value : check q w claim log = Ok value ->
  0 < down w /\ forall t, is_asked_for q t -> value <= tree_cost q t * down w.
Proof.
  unfold check. intros H. fold all in H.
  destruct (samples_of (width_of w) q w all 0 (rows q) (its_rows w) (its_weights w)) as [samples|] eqn:E;
    [|discriminate].
  unfold ensure in H. destruct (is_penalty_below q w && is_proper q) eqn:P; [|discriminate].
  apply andb_true_iff in P. destruct P as [P PR].
  unfold is_penalty_below in P. rewrite !andb_true_iff, !Z.leb_le, Z.ltb_lt in P.
  destruct P as [[[P0 P1] P2] P3]. split; [exact P3|]. intros t A.
  destruct (check_cases q w all samples claim [] log) as [b|] eqn:C; [|discriminate]. injection H as <-.
  assert (M := samples_of_spec _ _ _ _ _ E).
  assert (FE : Forall (fun f => (f < length (sensors q))%nat) (features t)).
  { destruct A as (_ & _ & A & _). eapply Forall_impl; [|exact A]. intros f. apply (proper_features PR). }
  destruct (stands_exists t FE) as (t' & T).
  assert (B := check_cases_spec samples M PR P0 claim t t' A T log [] b (NoDup_nil _) (fun _ _ I => match I with end)
    C).
  destruct A as (_ & L & _).
  assert (S := stands_losses t t' T L (rows q) samples (incl_refl _) M).
  destruct (stands_shape t t' T) as (_ & NS & _).
  unfold cost in B. rewrite NS in B. unfold tree_cost.
  assert (N := n_splits_nonneg t'). rewrite NS in N. nia.
Qed.

End Question.

Print Assumptions accepted_bounds_hold.
