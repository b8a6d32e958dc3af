(** Nodes whose sides are proven, and the theorem of a node: what the checker accepts is true. *)

From Coq Require Import ZArith List Bool Permutation Sorting.Sorted Lia Arith.
Import ListNotations.
From octmip Require Import Samples Sums Trees Inequalities Stumps BlockFacts StumpFacts SideFacts Checker.
From octmip Require Import ColumnFacts CheckFacts CountFacts.
Open Scope Z_scope.
Local Arguments Z.add : simpl never.
Local Arguments Z.sub : simpl never.
Local Arguments Z.mul : simpl never.

Section Rules.
Variable r : rules.
Hypothesis penalty_nonneg : 0 <= penalty r.
Hypothesis leaf_size_pos : (1 <= leaf_size r)%nat.

(** * Records whose sides are proven *)

Definition has_orders (samples : list sample) (all : list column) : Prop :=
  Forall (is_order samples) all /\ covers r all.

Lemma columns_orders d samples all : are_columns r d samples all -> has_orders samples all.
Proof. intros [F C]. split; [|exact C]. eapply Forall_impl; [|exact F]. intros c [O _]. exact O. Qed.

Lemma part_fresh samples all i edge is_low : has_orders samples all ->
  is_fresh r (part_of (key i) edge is_low samples) (columns_of i edge is_low all).
Proof.
  intros [F C]. split.
  - rewrite Forall_forall in *. intros c I. apply in_map_iff in I. destruct I as (c' & <- & I).
    destruct (F c' I) as [P SS]. simpl. split; [|reflexivity].
      split; simpl; [apply filter_perm, P|apply sorted_filter, SS].
  - intros c R. destruct (C c R) as (col & I & E).
    exists (unsolved (index col) (part_of (key i) edge is_low (order col))).
    split; [|exact E]. apply in_map_iff. exists col. auto.
Qed.

Section Below.
Variable d : nat.
Variable check_below : list sample -> list column -> node -> checked Z.
Hypothesis below : forall samples all proof b, all_sound r samples -> is_fresh r samples all ->
  check_below samples all proof = Ok b -> bounds r d samples b.

Lemma solve_sides_spec i edge samples all : all_sound r samples -> has_orders samples all ->
  forall sides left right b1 b2,
  bounds r d (part_of (key i) edge true samples) left -> bounds r d (part_of (key i) edge false samples) right ->
  solve_sides check_below i edge samples all sides left right = Ok (b1, b2) ->
  bounds r d (part_of (key i) edge true samples) b1 /\ bounds r d (part_of (key i) edge false samples) b2.
Proof.
  intros S F. induction sides as [|[is_left proof] sides IH]; intros left right b1 b2 L R H; simpl in H.
  - injection H as <- <-. auto.
  - destruct (check_below _ _ proof) as [b|] eqn:E; [|discriminate].
    assert (B : bounds r d (part_of (key i) edge is_left samples) b)
      by (eapply below; [apply sound_filter, S|apply part_fresh, F|exact E]).
    destruct is_left; [apply (IH _ _ b1 b2) in H|apply (IH _ _ b1 b2) in H]; auto; apply bounds_max; auto.
Qed.

Lemma solve_cuts_spec line samples all : all_sound r samples -> has_orders samples all ->
  forall steps c place last rest before c',
  is_column r d samples c -> order c = before ++ rest -> behind (index c) before last ->
  Z.of_nat (length before) = place ->
  solve_cuts check_below line samples all c steps place last rest = Ok c' ->
  is_column r d samples c'.
Proof.
  intros S F. induction steps as [|[distance sides] steps IH]; intros c place last rest before c' C O B L H; simpl in H.
  - injection H as <-. exact C.
  - destruct (walk (index c) rest last distance) as [[edge rest']|] eqn:W; [|discriminate].
    destruct (walk_spec _ _ _ _ _ _ _ B W) as (l & -> & D & B' & CUT).
    destruct (solve_sides check_below (index c) edge samples all sides 0 0) as [[b1 b2]|] eqn:E; [|discriminate].
    destruct (solve_sides_spec _ _ _ _ S F _ _ _ _ _ (bounds_zero r penalty_nonneg d _ (sound_filter r _ _ S))
      (bounds_zero r penalty_nonneg d _ (sound_filter r _ _ S)) E) as [B1 B2].
    assert (COL := C). destruct COL as [[P SS] SV]. rewrite <- O in CUT.
    destruct (cut_parts _ _ _ _ _ SS CUT) as [EL ER].
    apply (IH (solve_cut c (place + distance) (b1, b2)) (place + distance) (Some edge) rest' (before ++ l) c'); auto.
    + eapply solve_cut_column; eauto.
      * rewrite app_length. lia.
      * eapply bounds_perm; [|exact B1]. rewrite <- EL. apply filter_perm, P.
      * eapply bounds_perm; [|exact B2]. rewrite <- ER. apply filter_perm, P.
    + simpl. rewrite O, app_assoc. reflexivity.
    + rewrite app_length. lia.
Qed.

Lemma solve_records_spec samples : all_sound r samples -> forall records all all', are_columns r d samples all ->
  solve_records check_below samples all records = Ok all' -> are_columns r d samples all'.
Proof.
  intros S. induction records as [|[line i steps] records IH]; intros all all' A H; simpl in H; [injection H as <-;
    exact A|].
  destruct (column_of i all) as [c|] eqn:E.
  - destruct (column_of_spec _ _ _ E) as [I <-].
    destruct (solve_cuts check_below line samples all c steps 0 None (order c)) as [c'|] eqn:R; [|discriminate].
    assert (COL : is_column r d samples c) by (destruct A as [F _]; rewrite Forall_forall in F; auto).
    eapply IH; [|exact H]. apply replace_columns; auto.
    apply (solve_cuts_spec line samples all S (columns_orders _ _ _ A) steps c 0 None (order c) [] c'); auto.
    reflexivity.
  - destruct steps as [|[distance sides] steps]; [|discriminate]. eapply IH; eauto.
Qed.

Lemma solve_below_spec samples all of_all records b all' : all_sound r samples -> is_fresh r samples all ->
  solve_below check_below samples all of_all records = Ok (b, all') ->
  bounds r d samples b /\ are_columns r d samples all'.
Proof.
  intros S F H. unfold solve_below in H.
  destruct (match of_all with None => Ok 0 | Some proof => check_below samples all proof end) as [b0|] eqn:E;
    [|discriminate].
  destruct (solve_records check_below samples all records) as [all0|] eqn:R; [|discriminate].
  injection H as <- <-. split.
  - destruct of_all as [proof|]; [eapply below; eauto|]. injection E as <-. apply bounds_zero; auto.
  - eapply solve_records_spec; eauto. apply fresh_columns; auto.
Qed.

End Below.
Lemma gains_of_joined samples : forall v, gains_of samples v = joined gains samples v.
Proof. induction samples as [|s samples IH]; intros v; [reflexivity|apply IH]. Qed.

Lemma one_leaf_spec samples b : all_sound r samples -> b <= one_leaf samples -> leaf_bounds r samples b.
Proof.
  intros S B. unfold one_leaf in B. rewrite gains_of_joined in B. apply leaf_cost; auto.
Qed.

(** What [check_node] accepts is true. *)
Theorem check_node_spec : forall depth samples all proof b, all_sound r samples -> is_fresh r samples all ->
  check_node r depth samples all proof = Ok b -> bounds r depth samples b.
Proof.
  induction depth as [|depth IH]; intros samples all proof b S F H;
    destruct proof as [line|line levels leaf bound of_all records fault];
    try discriminate.
  cbn [check_node] in H. unfold ensure in H.
  destruct (_ && _) in H; [|discriminate].
  destruct (Nat.leb (Datatypes.S depth) 2) eqn:D2.
  - destruct (count_below r samples all records) as [[b1 all']|] eqn:E; [|discriminate].
    destruct (count_below_spec r penalty_nonneg leaf_size_pos _ _ _ _ _ S F E) as [B A].
    destruct fault; [discriminate|].
    destruct (Nat.eqb_spec (Datatypes.S depth) 1) as [D1|D1].
    + injection D1 as ->. destruct (Z.leb_spec bound b1); [|discriminate]. injection H as <-.
      eapply bounds_le; eauto.
    + apply Nat.leb_le in D2. assert (depth = 1%nat) by lia. subst depth.
      destruct (Z.leb_spec bound (one_leaf samples)) as [L|]; [|discriminate].
      destruct (check_columns_spec r _ _ _ _ _ _ H) as [-> _].
      apply Inequalities.node; [apply one_leaf_spec; auto|eapply columns_cuts; eauto].
  - destruct (solve_below (check_node r depth) samples all of_all records) as [[b1 all']|] eqn:E; [|discriminate].
    destruct (solve_below_spec depth _ IH _ _ _ _ _ _ S F E) as [B A].
    destruct fault; [discriminate|].
    destruct (Nat.eqb_spec (Datatypes.S depth) 1) as [D1|D1]; [injection D1 as ->; discriminate|].
    destruct (Z.leb_spec bound (one_leaf samples)) as [L|]; [|discriminate].
    destruct (check_columns_spec r _ _ _ _ _ _ H) as [-> _].
    apply Inequalities.node; [apply one_leaf_spec; auto|eapply columns_cuts; eauto].
Qed.

End Rules.
