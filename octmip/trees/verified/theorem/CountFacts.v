(** Nodes whose sides are counted. *)

From Coq Require Import ZArith List Bool Permutation Sorting.Sorted Lia Arith.
Import ListNotations.
From octmip Require Import Samples Sums Trees Inequalities Stumps BlockFacts StumpFacts SideFacts Checker.
From octmip Require Import ColumnFacts CheckFacts.
Open Scope Z_scope.
Local Arguments Z.add : simpl never.
Local Arguments Z.sub : simpl never.
Local Arguments Z.mul : simpl never.

Section Rules.
Variable r : rules.
Hypothesis penalty_nonneg : 0 <= penalty r.
Hypothesis leaf_size_pos : (1 <= leaf_size r)%nat.

Definition pairs_of (all : list column) : list (nat * list sample) := map (fun c => (index c, order c)) all.

Lemma pairs_orders d samples all : are_columns r d samples all -> all_orders r samples (pairs_of all).
Proof.
  intros [F C]. split.
  - rewrite Forall_forall in *. intros o I. apply in_map_iff in I. destruct I as (c & <- & I).
    destruct (F c I) as [O _]. exact O.
  - intros c R. destruct (C c R) as (col & I & <-). exists (order col). apply in_map_iff. exists col. auto.
Qed.

Lemma with_keys_pairs all : with_keys all = map (fun o => keyed (fst o) (snd o)) (pairs_of all).
Proof. unfold with_keys, pairs_of. rewrite map_map. reflexivity. Qed.

(** ** The order in which columns are counted *)

Lemma named_columns records all : incl (named records all) all.
Proof.
  induction records as [|[line i steps] records IH]; simpl; [intros c []|].
  destruct (column_of i all) as [c|] eqn:E; [|exact IH]. destruct (column_of_spec _ _ _ E) as [I _].
  intros x [<-|J]; [exact I|apply IH, J].
Qed.

Lemma named_covers records all c : In c all -> is_named records c = true ->
  exists c', In c' (named records all) /\ index c' = index c.
Proof.
  intros I. induction records as [|[line i steps] records IH]; simpl; [discriminate|].
  destruct (Nat.eqb_spec (index c) i) as [<-|N]; simpl.
  - intros _. assert (E : exists c', column_of (index c) all = Some c').
    { clear IH. induction all as [|x all IH]; simpl in *; [tauto|].
      destruct (Nat.eqb_spec (index x) (index c)); [eauto|]. destruct I as [<-|I]; [congruence|]. auto. }
    destruct E as (c' & E). rewrite E. exists c'. destruct (column_of_spec _ _ _ E). simpl. auto.
  - intros H. destruct (IH H) as (c' & J & E). exists c'. split; [|exact E].
    destruct (column_of i all); simpl; auto.
Qed.

Lemma by_records_columns d samples records all : are_columns r d samples all ->
  are_columns r d samples (by_records records all).
Proof.
  intros [F C]. unfold by_records. set (first := firstn (length all) records). split.
  - apply Forall_app. split; rewrite Forall_forall in *; intros c I.
    + apply F, (named_columns first all), I.
    + apply filter_In in I. apply F. tauto.
  - intros c R. destruct (C c R) as (col & I & <-). destruct (is_named first col) eqn:N.
    + destruct (named_covers first all col I N) as (c' & J & E). exists c'. split; [apply in_or_app; auto|exact E].
    + exists col. split; [|reflexivity]. apply in_or_app. right. apply filter_In. rewrite N. auto.
Qed.

Lemma stumps_of_spec d place samples all edges : all_sound r samples -> are_columns r d samples all ->
  Forall2 (fun edge both => bounds r 1 (part_of place edge true samples) (fst both) /\
      bounds r 1 (part_of place edge false samples) (snd both)) edges
    (stumps_of r place samples (with_keys all) edges).
Proof.
  intros S A. unfold stumps_of. rewrite with_keys_pairs.
  apply (stumps_spec r penalty_nonneg leaf_size_pos place samples (pairs_of all) edges S (pairs_orders _ _ _ A)).
Qed.

Lemma read_cuts_spec line c : forall steps place last rest read cuts before,
  read_cuts line c steps place last rest read = Ok cuts -> behind c before last ->
  Z.of_nat (length before) = place ->
  (forall cut, In cut read -> exists left right, is_cut c (before ++ rest) left (snd cut) right /\
    Z.of_nat (length left) = fst cut) ->
  forall cut, In cut cuts -> exists left right, is_cut c (before ++ rest) left (snd cut) right /\
    Z.of_nat (length left) = fst cut.
Proof.
  induction steps as [|[distance sides] steps IH]; intros place last rest read cuts before H B L R; simpl in H.
  - injection H as <-. intros cut I. rewrite rev'_rev in I. apply in_rev in I. auto.
  - destruct (walk c rest last distance) as [[edge rest']|] eqn:W; [|discriminate].
    destruct (walk_spec _ _ _ _ _ _ _ B W) as (l & -> & D & B' & C).
    rewrite app_assoc in *. eapply IH; eauto.
    + rewrite app_length. lia.
    + intros cut [<-|I]; [|apply R, I]. simpl. exists (before ++ l), rest'. split; [exact C|]. rewrite app_length. lia.
Qed.

Lemma solve_all_column samples : forall cuts sides c,
  is_column r 1 samples c ->
  (forall cut, In cut cuts -> exists l l', is_cut (index c) (order c) l (snd cut) l' /\ Z.of_nat (length l) = fst cut)
    ->
  Forall2 (fun edge both => bounds r 1 (part_of (key (index c)) edge true samples) (fst both) /\
    bounds r 1 (part_of (key (index c)) edge false samples) (snd both)) (map snd cuts) sides ->
  is_column r 1 samples (solve_all c cuts sides) /\ index (solve_all c cuts sides) = index c.
Proof.
  induction cuts as [|[place edge] cuts IH]; intros sides c C K B; simpl; [auto|].
  simpl in B. inversion B as [|? [b1 b2] ? ? [B1 B2] BS]; subst. simpl in B1, B2.
  destruct (K (place, edge)) as (lo & hi & CUT & N); [simpl; auto|]. simpl in CUT, N.
  assert (COL := C). destruct COL as [[P SS] SV].
  destruct (cut_parts _ _ _ _ _ SS CUT) as [EL ER].
  assert (PL : Permutation (part_of (key (index c)) edge true samples) lo) by (rewrite <- EL; apply filter_perm, P).
  assert (PR : Permutation (part_of (key (index c)) edge false samples) hi) by (rewrite <- ER; apply filter_perm, P).
  apply (IH _ (solve_cut c place (b1, b2))); auto.
  - eapply solve_cut_column; eauto; eapply bounds_perm; eauto.
  - intros cut I. apply K. simpl. auto.
Qed.

Lemma count_records_spec samples orders : forall records all all', all_sound r samples ->
  (forall place edges, Forall2 (fun edge both => bounds r 1 (part_of place edge true samples) (fst both) /\
      bounds r 1 (part_of place edge false samples) (snd both)) edges (stumps_of r place samples orders edges)) ->
  are_columns r 1 samples all -> count_records r samples orders all records = Ok all' -> are_columns r 1 samples all'.
Proof.
  induction records as [|[line i steps] records IH]; intros all all' S B A H; simpl in H; [injection H as <-; exact A|].
  destruct (column_of i all) as [c|] eqn:E.
  - destruct (column_of_spec _ _ _ E) as [I <-].
    destruct (read_cuts line (index c) steps 0 None (order c) []) as [cuts|] eqn:R; [|discriminate].
    assert (K := read_cuts_spec _ _ _ _ _ _ _ _ [] R eq_refl eq_refl (fun cut I => match I with end)).
    assert (COL : is_column r 1 samples c) by (destruct A as [F _]; rewrite Forall_forall in F; auto).
    eapply IH; [exact S|exact B| |exact H].
    apply replace_columns; [reflexivity| |exact A]. unfold count_cuts. apply solve_all_column; auto.
  - destruct steps as [|[distance sides] steps]; [|discriminate]. eapply IH; eauto.
Qed.

Lemma count_below_spec samples all records b all' : all_sound r samples -> is_fresh r samples all ->
  count_below r samples all records = Ok (b, all') -> bounds r 1 samples b /\ are_columns r 1 samples all'.
Proof.
  intros S F H. unfold count_below in H. assert (FC := fresh_columns r penalty_nonneg 1 _ _ S F).
  assert (B := fun place edges =>
    stumps_of_spec 1 place samples (by_records records all) edges S (by_records_columns _ _ records _ FC)).
  set (orders := with_keys _) in *.
  destruct (count_records r samples orders all records) as [all0|] eqn:E; [|discriminate]. injection H as <- <-.
  split; [|eapply count_records_spec; eauto].
  specialize (B (fun _ => 0) [0]).
  destruct (stumps_of _ _ _ _ _) as [|b rest]; inversion B as [|? ? ? ? [Q _] _]; subst.
  simpl. unfold part_of in Q. rewrite filter_all in Q by reflexivity. exact Q.
Qed.

End Rules.
