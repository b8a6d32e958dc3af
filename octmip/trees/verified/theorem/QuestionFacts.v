(** A question over rows and the same over samples: each tree has one over columns, no sample costs more than its
    row. *)

From Coq Require Import ZArith List Bool Permutation Sorting.Sorted Sorting.Mergesort Lia Arith.
Import ListNotations.
From octmip Require Import Specification Samples Sums Trees Inequalities Columns Checker ColumnFacts BlockFacts.
From octmip Require Import StumpFacts Whole Cases.
Open Scope Z_scope.
Local Arguments Z.add : simpl never.
Local Arguments Z.sub : simpl never.
Local Arguments Z.mul : simpl never.

Section Question.
Context {q : question} {w : numbers}.

Definition all : list place := places (length (sensors q)) (rows q).

(** A sample is that of a row. *)
Record matches (x : row) (s : sample) : Prop := {
  its_keys : keys s = keys_of all x;
  its_sound : sound (n_classes q) s;
  its_loss : forall label, (label < n_classes q)%nat ->
    price label s * up w + base_of w x * down w <= loss q label x * down w
}.

(** A cut of a column does what a split of a feature does. *)
Definition does (feature : nat) (threshold : Z) (missing : bool) (column : nat) (edge : Z) : Prop :=
  exists fill, nth_error all column = Some (feature, fill) /\
  forall x, In x (rows q) -> (or_else fill (reading feature x) <=? edge) = goes_left feature threshold missing x.

Inductive stands_for : Specification.tree -> Trees.tree -> Prop :=
| leaf_for label : stands_for (Specification.Leaf label) (Trees.Leaf label)
| split_for feature threshold missing l r column edge l' r' :
    does feature threshold missing column edge -> stands_for l l' -> stands_for r r' ->
    stands_for (Specification.Split feature threshold missing l r) (Trees.Split column edge l' r').

Lemma key_of_column x s column feature fill : matches x s -> nth_error all column = Some (feature, fill) ->
  key column s = or_else fill (reading feature x).
Proof.
  intros M E. unfold key. rewrite (its_keys x s M). unfold keys_of.
  apply nth_error_nth. exact (map_nth_error (fun p : place => or_else (snd p) (reading (fst p) x)) _ _ E).
Qed.

Lemma does_below feature threshold missing column edge x s :
  does feature threshold missing column edge -> In x (rows q) -> matches x s ->
  is_below column edge s = goes_left feature threshold missing x.
Proof.
  intros (fill & E & H) I M. unfold is_below. rewrite (key_of_column x s column feature fill M E). apply H, I.
Qed.

Lemma stands_answer t t' x s : stands_for t t' -> In x (rows q) -> matches x s -> answer t' s = label_of t x.
Proof.
  induction 1 as [|f th m l r c e l' r' D L IHL R IHR]; intros I M; simpl; [reflexivity|].
  rewrite (does_below _ _ _ _ _ _ _ D I M). destruct (goes_left f th m x); auto.
Qed.

Lemma stands_shape t t' : stands_for t t' -> levels t' = n_levels t /\ Trees.n_splits t' = Specification.n_splits t /\
  Trees.labels t' = Specification.labels t.
Proof.
  induction 1 as [|f th m l r c e l' r' D L (A & B & C) R (A' & B' & C')]; simpl; [auto|].
  rewrite A, B, C, A', B', C'. auto.
Qed.

Lemma stands_columns t t' : stands_for t t' -> forall c, In c (Trees.columns t') ->
  exists f fill, In f (features t) /\ nth_error all c = Some (f, fill).
Proof.
  induction 1 as [|f th m l r c e l' r' D L IHL R IHR]; simpl; [tauto|]. intros c' [<-|I].
  - destruct D as (fill & E & _). exists f, fill. auto.
  - apply in_app_or in I. destruct I as [I|I]; [destruct (IHL _ I) as (f' & fill & A & B)|
      destruct (IHR _ I) as (f' & fill & A & B)]; exists f', fill; split; auto; right; apply in_or_app; auto.
Qed.

Lemma matches_length xs ss : Forall2 matches xs ss -> length xs = length ss.
Proof. induction 1; simpl; congruence. Qed.

Lemma matches_filter (f : row -> bool) (g : sample -> bool) xs ss : Forall2 matches xs ss ->
  (forall x s, In x xs -> matches x s -> g s = f x) -> Forall2 matches (filter f xs) (filter g ss).
Proof.
  induction 1 as [|x s xs ss M F IH]; intros H; simpl; [constructor|].
  rewrite (H x s) by (simpl; auto). assert (IH' := IH (fun x' s' I M' => H x' s' (or_intror I) M')).
  destruct (f x); auto.
Qed.

Lemma stands_leaves t t' least : stands_for t t' -> forall xs ss, incl xs (rows q) -> Forall2 matches xs ss ->
  Specification.leaves_hold least t xs -> Trees.leaves_hold least t' ss.
Proof.
  induction 1 as [|f th m l r c e l' r' D L IHL R IHR]; intros xs ss I F H; simpl in *.
  - rewrite <- (matches_length _ _ F). exact H.
  - destruct H as [HL HR]. split.
    + eapply IHL; [|apply matches_filter; [exact F|]|exact HL].
      * intros x X. apply filter_In in X. apply I. tauto.
      * intros x s X M. apply (does_below f th m c e x s); auto.
    + eapply IHR; [|apply matches_filter; [exact F|]|exact HR].
      * intros x X. apply filter_In in X. apply I. tauto.
      * intros x s X M. cbn beta. rewrite (does_below f th m c e x s); auto.
Qed.

Lemma stands_losses t t' : stands_for t t' -> Forall (fun a => (a < n_classes q)%nat) (Specification.labels t) ->
  forall xs ss, incl xs (rows q) -> Forall2 matches xs ss ->
  paid t' ss * up w + base_total w xs * down w <= losses q t xs * down w.
Proof.
  intros T A xs ss I F. induction F as [|x s xs ss M F IH]; [unfold paid; simpl; lia|].
  unfold paid in *. cbn [total base_total losses].
  assert (IH' := IH (fun y Y => I y (or_intror Y))).
  assert (E := stands_answer t t' x s T (I x (or_introl eq_refl)) M). rewrite E.
  assert (B : (label_of t x < n_classes q)%nat).
  { rewrite <- E. rewrite Forall_forall in A. apply A. rewrite <- (proj2 (proj2 (stands_shape t t' T))).
    apply answer_in. }
  assert (P := its_loss x s M _ B). nia.
Qed.

(** ** Every split has a column *)

Lemma fold_min (values : list (option Z)) v : In (Some v) values ->
  fold_right (fun x least => Z.min (or_else 0 x) least) 0 values <= v.
Proof. induction values as [|x values IH]; simpl; [tauto|]. intros [->|I]; simpl; [lia|specialize (IH I); lia]. Qed.
Lemma fold_max (values : list (option Z)) v : In (Some v) values ->
  v <= fold_right (fun x most => Z.max (or_else 0 x) most) 0 values.
Proof. induction values as [|x values IH]; simpl; [tauto|]. intros [->|I]; simpl; [lia|specialize (IH I); lia]. Qed.

Lemma place_of_split feature threshold missing :
  exists fill edge, In (feature, fill) (places_of feature (map (reading feature) (rows q))) /\
  forall x, In x (rows q) -> (or_else fill (reading feature x) <=? edge) = goes_left feature threshold missing x.
Proof.
  set (values := map (reading feature) (rows q)). unfold places_of.
  assert (V : forall x, In x (rows q) -> In (reading feature x) values) by (intros x; apply in_map).
  destruct (existsb is_missing values) eqn:G.
  - set (below := fold_right (fun x least => Z.min (or_else 0 x) least) 0 values).
    set (above := fold_right (fun x most => Z.max (or_else 0 x) most) 0 values).
    destruct missing.
    + exists (below - 1), (Z.max threshold (below - 1)). split; [simpl; auto|]. intros x I. unfold goes_left.
      specialize (V x I). destruct (reading feature x) as [v|]; simpl.
      * assert (B := fold_min values v V). fold below in B.
        destruct (Z.leb_spec v (Z.max threshold (below - 1))), (Z.leb_spec v threshold); auto; lia.
      * apply Z.leb_le. lia.
    + exists (above + 1), (Z.min threshold above). split; [simpl; auto|]. intros x I. unfold goes_left.
      specialize (V x I). destruct (reading feature x) as [v|]; simpl.
      * assert (B := fold_max values v V). fold above in B.
        destruct (Z.leb_spec v (Z.min threshold above)), (Z.leb_spec v threshold); auto; lia.
      * apply Z.leb_gt. lia.
  - exists 0, threshold. split; [simpl; auto|]. intros x I. unfold goes_left. specialize (V x I).
    destruct (reading feature x) as [v|]; [reflexivity|]. exfalso.
    assert (E : existsb is_missing values = true) by (apply existsb_exists; exists None; auto). congruence.
Qed.

Lemma does_exists feature threshold missing : (feature < length (sensors q))%nat ->
  exists column edge, does feature threshold missing column edge.
Proof.
  intros L. destruct (place_of_split feature threshold missing) as (fill & edge & I & H).
  assert (J : In (feature, fill) all).
  { unfold all, places. apply in_flat_map. exists feature. split; [apply in_seq; lia|exact I]. }
  destruct (In_nth_error _ _ J) as (column & E). exists column, edge, fill. auto.
Qed.

Lemma stands_exists t : Forall (fun f => (f < length (sensors q))%nat) (features t) -> exists t', stands_for t t'.
Proof.
  induction t as [a|f th m l IHL r IHR]; intros F; [exists (Trees.Leaf a); constructor|].
  simpl in F. inversion F as [|? ? F0 F1]; subst. apply Forall_app in F1. destruct F1 as [F1 F2].
  destruct (IHL F1) as (l' & L), (IHR F2) as (r' & R), (does_exists f th m F0) as (c & e & D).
  exists (Trees.Split c e l' r'). constructor; auto.
Qed.

(** ** The whole numbers of a log *)

Lemma first_above_spec x : forall its_prices label, first_above q w x label its_prices = None ->
  forall i, (i < length its_prices)%nat -> 0 <= nth i its_prices 0 /\
    nth i its_prices 0 * up w + base_of w x * down w <= loss q (label + i) x * down w.
Proof.
  induction its_prices as [|p its_prices IH]; intros label H i L; simpl in L; [lia|]. simpl in H.
  destruct ((0 <=? p) && (p * up w + base_of w x * down w <=? loss q label x * down w)) eqn:E; [|discriminate].
  apply andb_true_iff in E. rewrite !Z.leb_le in E. destruct i.
  - rewrite Nat.add_0_r. exact E.
  - rewrite Nat.add_succ_r. apply (IH (S label) H i). lia.
Qed.

Lemma width_of_nonneg : 0 <= width_of w.
Proof.
  unfold width_of. assert (L := Z.log2_nonneg (sum (map Z.abs (its_weights w)) * top (map top (table w)))). lia.
Qed.

Lemma samples_of_spec : forall xs i table_rows weights samples,
  samples_of (width_of w) q w all i xs table_rows weights = Ok samples -> Forall2 matches xs samples.
Proof.
  induction xs as [|x xs IH]; intros i table_rows weights samples H; destruct table_rows as [|row_ table_rows],
    weights as [|v weights];
    simpl in H; try discriminate; [injection H as <-; constructor|].
  set (its_prices := prices_of q (nth row_ (table w) []) v) in *.
  destruct (first_above q w x 0 its_prices) eqn:A; [discriminate|].
  destruct (samples_of (width_of w) q w all (S i) xs table_rows weights) as [rest|] eqn:R; [|discriminate].
  injection H as <-. constructor; [|eapply IH; eauto].
  assert (L : length its_prices = n_classes q) by (unfold its_prices, prices_of; rewrite map_length; apply seq_length).
  assert (N := first_above_spec x its_prices 0%nat A).
  constructor; [reflexivity| |].
  - rewrite <- L. apply sample_of_sound; [apply width_of_nonneg|]. rewrite Forall_forall. intros p I.
    destruct (In_nth _ _ 0 I) as (j & J & <-). apply (N j J).
  - intros label B. unfold price; simpl. apply (N label). lia.
Qed.

End Question.
