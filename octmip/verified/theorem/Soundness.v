(** The theorem: what the checker accepts is true of every tree that is asked for. *)

From Coq Require Import ZArith List Bool Permutation Sorting.Sorted Sorting.Mergesort Lia Arith.
Import ListNotations.
From octmip Require Import Specification Samples Sums Trees Inequalities Columns Checker NodeFacts ScanFacts.
From octmip Require Import StumpFacts Whole Cases.
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

(** * Trees of a question and trees over columns *)

Section Question.
Variable q : question.
Variable w : numbers.

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

(** * The whole numbers of a log *)

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

Lemma samples_of_spec : forall xs i table_rows weights samples,
  samples_of q w all i xs table_rows weights = Ok samples -> Forall2 matches xs samples.
Proof.
  induction xs as [|x xs IH]; intros i table_rows weights samples H; destruct table_rows as [|row_ table_rows],
    weights as [|v weights];
    simpl in H; try discriminate; [injection H as <-; constructor|].
  set (its_prices := prices_of q (nth row_ (table w) []) v) in *.
  destruct (first_above q w x 0 its_prices) eqn:A; [discriminate|].
  destruct (samples_of q w all (S i) xs table_rows weights) as [rest|] eqn:R; [|discriminate].
  injection H as <-. constructor; [|eapply IH; eauto].
  assert (L : length its_prices = n_classes q) by (unfold its_prices, prices_of; rewrite map_length; apply seq_length).
  assert (N := first_above_spec x its_prices 0%nat A).
  constructor; [reflexivity| |].
  - rewrite <- L. apply sample_of_sound. rewrite Forall_forall. intros p I.
    destruct (In_nth _ _ 0 I) as (j & J & <-). apply (N j J).
  - intros label B. unfold price; simpl. apply (N label). lia.
Qed.

(** * Cases *)

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
  destruct (samples_of q w all 0 (rows q) (its_rows w) (its_weights w)) as [samples|] eqn:E; [|discriminate].
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
