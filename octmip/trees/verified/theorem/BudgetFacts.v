(** Budgets: what a tree reads may be read in the case of its sensors. *)

From Coq Require Import ZArith List Bool Permutation Sorting.Sorted Sorting.Mergesort Lia Arith.
Import ListNotations.
From octmip Require Import Specification Columns Whole Cases.
Open Scope Z_scope.
Local Arguments Z.add : simpl never.
Local Arguments Z.sub : simpl never.
Local Arguments Z.mul : simpl never.

Section Question.
Context {q : question} {w : numbers}.

Definition lsum (f : nat -> Z) (l : list nat) : Z := fold_right (fun i acc => f i + acc) 0 l.

Lemma lsum_app f l l' : lsum f (l ++ l') = lsum f l + lsum f l'.
Proof. induction l; simpl; lia. Qed.

Lemma lsum_incl f : (forall i, 0 <= f i) -> forall l m, NoDup l -> incl l m -> lsum f l <= lsum f m.
Proof.
  intros P. induction l as [|x l IH]; intros m D I; simpl.
  - clear D I. induction m as [|y m IH]; simpl; [lia|]. specialize (P y). lia.
  - inversion D as [|? ? N D']; subst. destruct (in_split x m (I x (or_introl eq_refl))) as (m1 & m2 & ->).
    assert (J : incl l (m1 ++ m2)).
    { intros y Y. assert (Z0 := I y (or_intror Y)). apply in_app_or in Z0. apply in_or_app.
      destruct Z0 as [Z0|[<-|Z0]]; auto. contradiction. }
    specialize (IH _ D' J). rewrite lsum_app in *. simpl. lia.
Qed.

Lemma lsum_map f g l : lsum f (map g l) = lsum (fun i => f (g i)) l.
Proof. induction l; simpl; lia. Qed.
Lemma lsum_ext f g l : (forall i, In i l -> f i = g i) -> lsum f l = lsum g l.
Proof. induction l as [|x l IH]; simpl; intros H; [reflexivity|]. rewrite H, IH by auto. reflexivity. Qed.

Lemma paid_from_sum t : forall costs_ k, paid_from q t k costs_ =
  lsum (fun i => if reads q t (k + i) then nth i costs_ 0 else 0) (seq 0 (length costs_)).
Proof.
  induction costs_ as [|c costs_ IH]; intros k; [reflexivity|]. cbn [paid_from length seq lsum fold_right].
  rewrite IH, <- seq_shift. fold (lsum (fun i => if reads q t (k + i) then nth i (c :: costs_) 0 else 0)
    (map S (seq 0 (length costs_)))). rewrite lsum_map. rewrite Nat.add_0_r. f_equal. apply lsum_ext. intros i _.
  rewrite Nat.add_succ_r. reflexivity.
Qed.

Lemma paid_at_least t l : Forall (fun c => 0 <= c) (sensor_costs q) -> NoDup l ->
  (forall s, In s l -> reads q t s = true) -> lsum (fun s => nth s (sensor_costs q) 0) l <= sensor_cost q t.
Proof.
  intros P D R. unfold sensor_cost. rewrite paid_from_sum. simpl.
  set (n := length (sensor_costs q)).
  assert (N : forall i, 0 <= nth i (sensor_costs q) 0).
  { intros i. destruct (Nat.lt_ge_cases i n); [rewrite Forall_forall in P; apply P, nth_In; auto|].
    rewrite nth_overflow; [lia|exact H]. }
  set (few := filter (fun s => Nat.ltb s n) l).
  assert (E : lsum (fun s => nth s (sensor_costs q) 0) l = lsum (fun s => nth s (sensor_costs q) 0) few).
  { unfold few. clear -n. induction l as [|s l IH]; simpl; [reflexivity|]. destruct (Nat.ltb_spec s n); simpl; [lia|].
    rewrite nth_overflow by exact H. lia. }
  rewrite E. rewrite lsum_ext with (g := fun i => if reads q t i then nth i (sensor_costs q) 0 else 0).
  - apply lsum_incl.
    + intros i. destruct (reads q t i); [apply N|lia].
    + apply NoDup_filter, D.
    + intros s I. apply filter_In in I. destruct I as [_ I]. apply Nat.ltb_lt in I. apply in_seq. lia.
  - intros s I. apply filter_In in I. rewrite R by tauto. reflexivity.
Qed.

(** A tree keeps to what is decided. *)
Definition keeps_to (t : Specification.tree) (ds : decisions) : Prop :=
  forall sensor is_read, In (sensor, is_read) ds -> reads q t sensor = is_read.

Definition taken (ds : decisions) : list nat := map fst (filter snd ds).

Lemma paid_so_far_sum ds : paid_so_far q ds = lsum (fun s => nth s (sensor_costs q) 0) (taken ds).
Proof.
  induction ds as [|[s b] ds IH]; [reflexivity|]. unfold taken in *. simpl. destruct b; simpl; lia.
Qed.

Lemma decided_some s ds b : decided s ds = Some b -> In (s, b) ds.
Proof.
  unfold decided. destruct (find _ ds) as [[s' b']|] eqn:F; [|discriminate]. intros E. injection E as ->.
  apply find_some in F. simpl in F. destruct F as [I E]. apply Nat.eqb_eq in E. subst. exact I.
Qed.
Lemma decided_none s ds : decided s ds = None -> ~ In s (map fst ds).
Proof.
  unfold decided. destruct (find _ ds) as [[s' b']|] eqn:F; [discriminate|]. intros _ I.
  apply in_map_iff in I. destruct I as ([s' b'] & E & I). simpl in E. subst.
  assert (N := find_none _ _ F _ I). simpl in N. rewrite Nat.eqb_refl in N. discriminate.
Qed.

Lemma taken_incl ds s : In s (taken ds) -> In s (map fst ds) /\ In (s, true) ds.
Proof.
  unfold taken. intros I. apply in_map_iff in I. destruct I as ([s' b] & E & I). simpl in E. subst.
  apply filter_In in I. simpl in I. destruct I as [I ->]. split; [|exact I]. apply in_map_iff. exists (s, true). auto.
Qed.

Lemma taken_nodup ds : NoDup (map fst ds) -> NoDup (taken ds).
Proof.
  induction ds as [|[s b] ds IH]; simpl; intros D; [constructor|]. inversion D as [|? ? N D']; subst.
  unfold taken. simpl. destruct b; simpl; [|apply IH, D']. constructor; [|apply IH, D'].
  intros I. apply N. apply (taken_incl ds s I).
Qed.

Lemma may_read_what_is_read t ds sensor : Forall (fun c => 0 <= c) (sensor_costs q) -> NoDup (map fst ds) ->
  keeps_to t ds -> is_within q (sensor_cost q t) -> reads q t sensor = true -> may_read_sensor q ds sensor = true.
Proof.
  intros P D K W R. unfold may_read_sensor. destruct (decided sensor ds) as [b|] eqn:E.
  - rewrite <- (K _ _ (decided_some _ _ _ E)). exact R.
  - assert (N := decided_none _ _ E).
    assert (H : lsum (fun s => nth s (sensor_costs q) 0) (sensor :: taken ds) <= sensor_cost q t).
    { apply paid_at_least; auto.
      - constructor; [|apply taken_nodup, D]. intros I. apply N. apply (taken_incl _ _ I).
      - intros s [<-|I]; [exact R|]. apply K. apply (taken_incl _ _ I). }
    simpl in H. rewrite paid_so_far_sum. unfold can_be_paid, is_within in *.
    destruct (budget q); [|reflexivity]. apply Z.leb_le. nia.
Qed.

Lemma reads_feature t f : In f (features t) -> reads q t (sensor_of q f) = true.
Proof. intros I. unfold reads. apply existsb_exists. exists f. split; [exact I|apply Nat.eqb_refl]. Qed.

End Question.
