(** Orders of samples, blocks of them, and the sums of their parts on both sides of an edge. *)

From Coq Require Import ZArith List Bool Permutation Sorting.Sorted Lia Arith.
Import ListNotations.
From octmip Require Import Samples Sums PackFacts Trees Inequalities Stumps.
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

(** * Blocks *)

Definition sums_of (l : list sample) : sums := Sums (total packed l) (total reach l) (total (fun _ => 1) l).

Fixpoint run_of (place : sample -> Z) (c : nat) (l : list sample) : run :=
  match l with [] => Done | s :: rest => Next (place s) (packed s) (reach s) (key c s) (run_of place c rest) end.

Record is_block (place : sample -> Z) (c : nat) (b : block) (l : list sample) : Prop := {
  its_run : held b = run_of place c l;
  its_sums : whole b = sums_of l;
  its_places : forall s, In s l -> lowest b <= place s <= highest b
}.

Lemma close_spec place c all : forall l g i n low high, exists low' high',
  close all (run_of place c l) g i n low high
    = Block all (Sums (g + total packed l) (i + total reach l) (n + total (fun _ => 1) l)) low' high' /\
  low' <= low /\ high <= high' /\ forall s, In s l -> low' <= place s <= high'.
Proof.
  induction l as [|s l IH]; intros g i n low high; cbn [run_of close total].
  - exists low, high. rewrite !Z.add_0_r. repeat split; try lia; simpl in *; tauto.
  - destruct (IH (g + packed s) (i + reach s) (n + 1) (Z.min low (place s)) (Z.max high (place s)))
      as (low' & high' & E & L & H & B).
    exists low', high'. rewrite E, <- !Z.add_assoc. split; [reflexivity|]. split; [lia|]. split; [lia|].
    intros x [<-|I]; [lia|apply B, I].
Qed.

Lemma put_before_spec place c l blocks ls : Forall2 (is_block place c) blocks ls ->
  exists ls', concat ls' = l ++ concat ls /\ Forall2 (is_block place c) (put_before (run_of place c l) blocks) ls'.
Proof.
  intros F. destruct l as [|s l]; [exists ls; auto|]. exists ((s :: l) :: ls). split; [reflexivity|].
  cbn [run_of put_before]. constructor; [|exact F].
  destruct (close_spec place c (Next (place s) (packed s) (reach s) (key c s) (run_of place c l)) l
    (packed s) (reach s) 1 (place s) (place s)) as (low & high & -> & L & H & B).
  constructor; [reflexivity|reflexivity|]. intros x [<-|I]; [simpl; lia|apply B, I].
Qed.

Definition keyed (c : nat) (l : list sample) : list (Z * sample) := map (fun s => (key c s, s)) l.

Lemma split_order_spec place c : forall l free, exists l0 ls, l = l0 ++ concat ls /\
  fst (split_order place free (keyed c l)) = run_of place c l0 /\
  Forall2 (is_block place c) (snd (split_order place free (keyed c l))) ls.
Proof.
  induction l as [|s l IH]; intros free; [exists [], []; simpl; auto|].
  cbn [keyed map split_order]. fold (keyed c l).
  destruct (IH (match free with O => block_size | S free' => free' end)) as (l0 & ls & E & R & B).
  destruct (split_order place _ (keyed c l)) as [r blocks]. simpl in R, B. subst r.
  assert (T : exists l1 ls', s :: l = l1 ++ concat ls' /\
    Next (place s) (packed s) (reach s) (key c s) (run_of place c l0) = run_of place c l1 /\
    Forall2 (is_block place c) blocks ls') by (exists (s :: l0), ls; rewrite E; auto).
  destruct free; [|exact T]. destruct (differs _ _); [|exact T].
  destruct (put_before_spec place c l0 blocks ls B) as (ls' & E' & B').
  exists [s], ls'. rewrite E, E'. auto.
Qed.

Theorem blocks_of_spec place c l : exists ls, concat ls = l /\
  Forall2 (is_block place c) (blocks_of place (keyed c l)) ls.
Proof.
  unfold blocks_of. destruct (split_order_spec place c l block_size) as (l0 & ls & E & R & B).
  destruct (split_order _ _ _) as [r blocks]. simpl in R, B. subst r l. apply put_before_spec, B.
Qed.

(** * Sides of an edge *)

Lemma part_app place edge is_low l l' :
  part_of place edge is_low (l ++ l') = part_of place edge is_low l ++ part_of place edge is_low l'.
Proof. apply filter_app. Qed.

Lemma sums_app l l' : sums_of (l ++ l') = Sums (gained (sums_of l) + gained (sums_of l'))
  (reached (sums_of l) + reached (sums_of l')) (counted (sums_of l) + counted (sums_of l')).
Proof. unfold sums_of. simpl. rewrite !total_app. reflexivity. Qed.

Lemma is_in_low edge place : is_in edge true place = (place <=? edge).
Proof. unfold is_in. destruct (place <=? edge); reflexivity. Qed.
Lemma is_in_high edge place : is_in edge false place = negb (place <=? edge).
Proof. unfold is_in. destruct (place <=? edge); reflexivity. Qed.

Lemma sums_below_spec place c edge : forall l g i n, sums_below edge (run_of place c l) g i n =
  let low := part_of place edge true l in
  Sums (g + total packed low) (i + total reach low) (n + total (fun _ => 1) low).
Proof.
  unfold part_of. induction l as [|s l IH]; intros g i n; cbn [run_of sums_below filter]; cbv zeta.
  - simpl. rewrite !Z.add_0_r. reflexivity.
  - rewrite !is_in_low. destruct (place s <=? edge); cbn [total]; rewrite IH; cbv zeta; [|reflexivity].
    rewrite <- !Z.add_assoc. reflexivity.
Qed.

Lemma below_spec place c edge b l : is_block place c b l -> below edge b = sums_of (part_of place edge true l).
Proof.
  intros [R S P]. unfold below. destruct (Z.leb_spec (highest b) edge) as [H|H].
  - rewrite S. f_equal. unfold part_of. symmetry. clear R S. induction l as [|s l IH]; [reflexivity|]. cbn [filter].
    assert (Q := P s (or_introl eq_refl)). rewrite is_in_low. destruct (Z.leb_spec (place s) edge); [|lia].
    f_equal. apply IH. intros x I. apply P. simpl. auto.
  - destruct (Z.ltb_spec edge (lowest b)) as [L|L].
    + assert (E : part_of place edge true l = []); [|rewrite E; reflexivity].
      unfold part_of. clear R S. induction l as [|s l IH]; [reflexivity|]. cbn [filter].
      assert (Q := P s (or_introl eq_refl)). rewrite is_in_low. destruct (Z.leb_spec (place s) edge); [lia|].
      apply IH. intros x I. apply P. simpl. auto.
    + rewrite R, sums_below_spec. reflexivity.
Qed.

Lemma total_sides what place edge l :
  total what l = total what (part_of place edge true l) + total what (part_of place edge false l).
Proof.
  unfold part_of. induction l as [|s l IH]; [reflexivity|]. cbn [filter]. rewrite is_in_low, is_in_high.
  destruct (place s <=? edge); cbn [negb total]; rewrite IH; lia.
Qed.

Lemma less_spec place edge l :
  less (sums_of l) (sums_of (part_of place edge true l)) = sums_of (part_of place edge false l).
Proof.
  unfold less, sums_of. simpl. rewrite (total_sides packed place edge l), (total_sides reach place edge l),
    (total_sides (fun _ => 1) place edge l). f_equal; lia.
Qed.
