(** A node that the checker accepts is true. *)

From Coq Require Import ZArith List Bool Permutation Sorting.Sorted Lia Arith.
Import ListNotations.
From octmip Require Import Samples Sums Trees Inequalities Stumps ScanFacts StumpFacts Sides SideFacts Checker.
Open Scope Z_scope.
Local Arguments Z.add : simpl never.
Local Arguments Z.sub : simpl never.
Local Arguments Z.mul : simpl never.

Lemma rev'_rev (A : Type) (l : list A) : rev' l = rev l.
Proof. unfold rev'. symmetry. apply rev_alt. Qed.

(** * Cuts of an order *)

(** A cut: the samples to its left, the key of the last of them, and the samples to its right. *)
Definition is_cut (c : nat) (order left : list sample) (edge : Z) (right : list sample) : Prop :=
  order = left ++ right /\ (exists l x, left = l ++ [x] /\ key c x = edge) /\
  (exists s l, right = s :: l /\ key c s <> edge).

Lemma sorted_app (c : nat) (l l' : list sample) : StronglySorted (key_le c) (l ++ l') ->
  (forall x y, In x l -> In y l' -> key c x <= key c y) /\ StronglySorted (key_le c) l'.
Proof.
  induction l as [|s l IH]; simpl; intros H; [split; [tauto|exact H]|].
  inversion H as [|? ? H0 F]; subst. destruct (IH H0) as [A B]. split; [|exact B].
  intros x y [<-|X] Y; [|auto]. rewrite Forall_forall in F. apply F, in_or_app. auto.
Qed.

Lemma filter_all (f : sample -> bool) l : (forall s, In s l -> f s = true) -> filter f l = l.
Proof.
  induction l as [|s l IH]; simpl; intros H; [reflexivity|]. rewrite H by auto. f_equal. auto.
Qed.
Lemma filter_none (f : sample -> bool) l : (forall s, In s l -> f s = false) -> filter f l = [].
Proof. induction l as [|s l IH]; simpl; intros H; [reflexivity|]. rewrite H by auto. auto. Qed.

Lemma cut_keys c order left edge right : StronglySorted (key_le c) order -> is_cut c order left edge right ->
  (forall x, In x left -> key c x <= edge) /\ (forall y, In y right -> edge < key c y).
Proof.
  intros SS (-> & (l & x & -> & E) & (s & l2 & -> & N)).
  destruct (sorted_app _ _ _ SS) as [A B]. split.
  - intros y Y. apply in_app_or in Y. destruct Y as [Y|[<-|[]]]; [|lia].
    rewrite <- app_assoc in SS. destruct (sorted_app _ _ _ SS) as [C _]. rewrite <- E. apply C; simpl; auto.
  - intros y Y. assert (K : key c x <= key c s) by (apply A; [apply in_or_app; simpl; auto|simpl; auto]).
    destruct Y as [<-|Y]; [lia|]. inversion B as [|? ? _ F]; subst. rewrite Forall_forall in F. specialize (F y Y).
    unfold key_le in F. lia.
Qed.

Lemma cut_parts c order left edge right : StronglySorted (key_le c) order -> is_cut c order left edge right ->
  part_of (key c) edge true order = left /\ part_of (key c) edge false order = right.
Proof.
  intros SS C. destruct (cut_keys _ _ _ _ _ SS C) as [L R]. destruct C as [-> _].
  unfold part_of. rewrite !filter_app. split.
  - rewrite filter_all, filter_none; [apply app_nil_r| |]; intros s I; unfold is_in.
    + specialize (R s I). destruct (Z.leb_spec (key c s) edge); [lia|reflexivity].
    + specialize (L s I). destruct (Z.leb_spec (key c s) edge); [reflexivity|lia].
  - rewrite filter_none, filter_all; [reflexivity| |]; intros s I; unfold is_in.
    + specialize (R s I). destruct (Z.leb_spec (key c s) edge); [lia|reflexivity].
    + specialize (L s I). destruct (Z.leb_spec (key c s) edge); [reflexivity|lia].
Qed.

(** What a walk along an order has left behind. *)
Definition behind (c : nat) (before : list sample) (last : option Z) : Prop :=
  match last with None => before = [] | Some k => exists l x, before = l ++ [x] /\ key c x = k end.

Lemma walk_spec c : forall rest before last distance edge rest',
  behind c before last -> walk c rest last distance = Some (edge, rest') ->
  exists l, rest = l ++ rest' /\ Z.of_nat (length l) = distance /\ behind c (before ++ l) (Some edge) /\
    is_cut c (before ++ rest) (before ++ l) edge rest'.
Proof.
  induction rest as [|s rest IH]; intros before last distance edge rest' B W; simpl in W.
  - destruct (distance =? 0); [|discriminate]. destruct last; discriminate.
  - destruct (Z.eqb_spec distance 0) as [->|N].
    + destruct last as [k|]; [|discriminate]. destruct (Z.eqb_spec k (key c s)) as [|K]; [discriminate|].
      injection W as -> <-. exists []. rewrite app_nil_r. repeat split; auto.
      exists s, rest. split; [reflexivity|congruence].
    + assert (B0 : behind c (before ++ [s]) (Some (key c s))) by (exists before, s; auto).
      destruct (IH _ _ _ _ _ B0 W) as (l & -> & L & B' & C). rewrite <- !app_assoc in *. simpl in *.
      exists (s :: l). repeat split; try apply C; auto. cbn [length]. lia.
Qed.

Section Rules.
Variable r : rules.
Hypothesis penalty_nonneg : 0 <= penalty r.
Hypothesis leaf_size_pos : (1 <= leaf_size r)%nat.

(** * Columns *)

(** The bounds of the sides of its cuts are true. *)
Definition is_solved (d : nat) (order : list sample) (entries : list (Z * Z)) : Prop :=
  length entries = pred (length order) /\
  forall l1 l2, order = l1 ++ l2 -> l1 <> [] -> l2 <> [] ->
    bounds r d l1 (fst (nth (length l1 - 1) entries (0, 0))) /\
    bounds r d l2 (snd (nth (length l1 - 1) entries (0, 0))).

Definition is_order (samples : list sample) (c : column) : Prop :=
  Permutation samples (order c) /\ StronglySorted (key_le (index c)) (order c).

Definition is_column (d : nat) (samples : list sample) (c : column) : Prop :=
  is_order samples c /\ is_solved d (order c) (solved c).

Definition covers (all : list column) : Prop :=
  forall c, may_read r c = true -> exists col, In col all /\ index col = c.

(** Columns of which nothing is known yet. *)
Definition is_fresh (samples : list sample) (all : list column) : Prop :=
  Forall (fun c => is_order samples c /\ c = unsolved (index c) (order c)) all /\ covers all.

Definition are_columns (d : nat) (samples : list sample) (all : list column) : Prop :=
  Forall (is_column d samples) all /\ covers all.

Lemma nth_zeros (A : Type) (l : list A) i : nth i (map (fun _ => (0, 0)) l) (0, 0) = (0, 0).
Proof. revert i. induction l; destruct i; simpl; auto. Qed.

Lemma fresh_columns d samples all : all_sound r samples -> is_fresh samples all -> are_columns d samples all.
Proof.
  intros S [F C]. split; [|exact C]. rewrite Forall_forall in *. intros c I. destruct (F c I) as [O E].
  split; [exact O|]. rewrite E. simpl. destruct O as [P _].
  assert (So : all_sound r (order c)) by (eapply sound_perm; eauto).
  split; [destruct (order c); simpl; rewrite ?map_length; reflexivity|].
  intros l1 l2 L _ _.
  assert (Z0 : nth (length l1 - 1) match order c with [] => [] | _ :: rest => map (fun _ => (0, 0)) rest end (0,
    0) = (0, 0))
    by (destruct (order c); [apply nth_nil|apply nth_zeros]).
  rewrite Z0. rewrite L in So. unfold all_sound in So. apply Forall_app in So.
  split; apply bounds_zero; simpl; tauto.
Qed.

Lemma nth_put place value : forall entries i d,
  (nth i (put place value entries) d = value /\ Z.of_nat (S i) = place) \/
  nth i (put place value entries) d = nth i entries d.
Proof.
  intros entries. revert place. induction entries as [|e entries IH]; intros place i d; simpl; [auto|].
  destruct (Z.eqb_spec place 1) as [->|N].
  - destruct i; simpl; auto.
  - destruct i; [simpl; auto|]. simpl nth. destruct (IH (place - 1) i d) as [[A B]|A]; [left|right]; auto.
    split; auto. lia.
Qed.

Lemma put_length place value entries : length (put place value entries) = length entries.
Proof.
  revert place. induction entries as [|e entries IH]; intros place; simpl; [reflexivity|].
  destruct (place =? 1); simpl; auto.
Qed.

Lemma app_same_length (A : Type) (l1 l2 m1 m2 : list A) :
  l1 ++ l2 = m1 ++ m2 -> length l1 = length m1 -> l1 = m1 /\ l2 = m2.
Proof.
  revert m1. induction l1 as [|x l1 IH]; intros [|y m1] E L; simpl in *; try discriminate; auto.
  injection E as -> E. destruct (IH m1 E) as [-> ->]; auto.
Qed.

Lemma solve_cut_column d samples c place left edge right b1 b2 :
  is_column d samples c -> is_cut (index c) (order c) left edge right -> Z.of_nat (length left) = place ->
  bounds r d left b1 -> bounds r d right b2 -> is_column d samples (solve_cut c place (b1, b2)).
Proof.
  intros [O [L S]] C P B1 B2. split; [exact O|]. simpl. split; [rewrite put_length; exact L|].
  intros l1 l2 E N1 N2. destruct (nth_put place (b1, b2) (solved c) (length l1 - 1) (0, 0)) as [[-> Q]| ->]; [|auto].
  destruct C as (E' & _ & _). rewrite E' in E.
  destruct (app_same_length _ _ _ _ _ E) as [-> ->]; [|auto].
  destruct l1; [congruence|]. simpl length in *. lia.
Qed.

Lemma replace_columns d samples new all : index new = index new ->
  is_column d samples new -> are_columns d samples all -> are_columns d samples (replace new all).
Proof.
  intros _ N [F C]. split.
  - clear C. induction all as [|c all IH]; simpl; [constructor|]. inversion F; subst.
    destruct (Nat.eqb (index c) (index new)); constructor; auto.
  - intros c R. destruct (C c R) as (col & I & E). clear F C. induction all as [|c' all IH]; simpl in *; [tauto|].
    destruct (Nat.eqb_spec (index c') (index new)) as [Q|Q].
    + destruct I as [<-|I]; [exists new; split; [simpl; auto|congruence]|exists col; simpl; auto].
    + destruct I as [<-|I]; [exists c'; simpl; auto|]. destruct (IH I) as (col' & I' & E'). exists col'. simpl. auto.
Qed.

Lemma column_of_spec i all c : column_of i all = Some c -> In c all /\ index c = i.
Proof.
  induction all as [|c' all IH]; simpl; [discriminate|]. destruct (Nat.eqb_spec (index c') i) as [E|E].
  - intros H. injection H as <-. auto.
  - intros H. destruct (IH H). auto.
Qed.

(** * The check of a column *)

Fixpoint last_key (c : nat) (last : option Z) (l : list sample) : option Z :=
  match l with [] => last | s :: l' => last_key c (Some (key c s)) l' end.

Lemma last_key_snoc c : forall l last x, last_key c last (l ++ [x]) = Some (key c x).
Proof. induction l; simpl; auto. Qed.

Lemma check_cuts_spec line c bound n : forall rest place last left right v,
  check_cuts r line c bound n place last rest left right = Ok v ->
  (length rest < length left)%nat -> (length rest < length right)%nat ->
  forall l1 s l2 k, rest = l1 ++ s :: l2 -> last_key c last l1 = Some k -> k <> key c s ->
  Z.of_nat (leaf_size r) <= place + Z.of_nat (length l1) <= n - Z.of_nat (leaf_size r) ->
  bound <= nth (length l1) left 0 + nth (length l1) right 0 + penalty r.
Proof.
  induction rest as [|s' rest IH]; intros place last left right v C LL LR l1 s l2 k E K N W.
  - destruct l1; discriminate.
  - destruct left as [|a left]; [simpl in LL; lia|]. destruct right as [|b right]; [simpl in LR; lia|].
    simpl in C, LL, LR.
    destruct l1 as [|x l1]; simpl in E; injection E as -> ->.
    + simpl in K, W. subst last. simpl nth.
      match type of C with (if ?a && ?b && ?c && ?d then _ else _) = _ =>
        assert (A1 : a = true) by (apply Z.leb_le; lia); assert (A2 : b = true) by (apply Z.leb_le; lia);
        assert (A3 : c = true) by (apply negb_true_iff, Z.eqb_neq, N); rewrite A1, A2, A3 in C end.
      simpl in C. destruct (Z.ltb_spec (a + b + penalty r) bound); [discriminate|lia].
    + match type of C with (if ?a then _ else _) = _ => destruct a; [discriminate|] end.
      simpl nth. eapply IH; eauto; try lia. cbn [length] in W. lia.
Qed.

Lemma check_column_spec line d bound all c v samples :
  all_sound r samples -> is_column d samples c -> bounds r d samples all ->
  check_column r line (S d) bound all c = Ok v ->
  forall left edge right, is_cut (index c) (order c) left edge right ->
  (leaf_size r <= length left)%nat -> (leaf_size r <= length right)%nat ->
  exists b1 b2, bounds r d left b1 /\ bounds r d right b2 /\ bound <= penalty r + b1 + b2.
Proof.
  intros S [[P SS] [L SV]] A C left edge right CUT WL WR. unfold check_column in C.
  rewrite !rev'_rev in C. simpl pred in C. rewrite total_one in C.
  set (ls := side _ _ (order c) _ _) in C. set (rs := side _ _ (rev (order c)) _ _) in C.
  assert (So : all_sound r (order c)) by (eapply sound_perm; eauto).
  assert (Sr : all_sound r (rev (order c))) by (eapply sound_perm; [apply Permutation_rev|exact So]).
  assert (AL : along (bounds r d) [] (order c) ls).
  { apply side_along; auto; [|eapply bounds_perm; eauto].
    intros l1 l2 E N1 N2. change 0 with (fst (0, 0)). rewrite map_nth. apply (SV l1 l2); auto. }
  assert (AR : along (bounds r d) [] (rev (order c)) rs).
  { apply side_along; auto; [|eapply bounds_perm; [|exact A]; eapply Permutation_trans;
    [exact P|apply Permutation_rev]].
    intros l1 l2 E N1 N2. assert (E' : order c = rev l2 ++ rev l1)
      by (rewrite <- rev_app_distr, <- E, rev_involutive; reflexivity).
    destruct (SV (rev l2) (rev l1) E') as [_ B].
    { intros Z0. apply N2. rewrite <- (rev_involutive l2), Z0. reflexivity. }
    { intros Z0. apply N1. rewrite <- (rev_involutive l1), Z0. reflexivity. }
    eapply bounds_perm; [apply Permutation_sym, Permutation_rev|].
    assert (LE : length (order c) = (length l1 + length l2)%nat)
      by (rewrite E', app_length, !rev_length; lia).
    assert (0 < length l1)%nat by (destruct l1; [congruence|simpl; lia]).
    assert (0 < length l2)%nat by (destruct l2; [congruence|simpl; lia]).
    rewrite rev_nth by (rewrite map_length; lia). rewrite map_length, L.
    rewrite rev_length in B.
    replace (pred (length (order c)) - Datatypes.S (length l1 - 1))%nat with (length l2 - 1)%nat by lia.
    change 0 with (snd (0, 0)). rewrite map_nth. exact B. }
  destruct CUT as (E & (l & x & EL & K) & (s & l2 & ER & N)).
  assert (B1 := along_nth _ _ _ _ AL left right E). simpl in B1.
  assert (E' : rev (order c) = rev right ++ rev left) by (rewrite E, rev_app_distr; reflexivity).
  assert (B2 := along_nth _ _ _ _ AR _ _ E'). simpl in B2. rewrite rev_length in B2.
  assert (LS : length ls = Datatypes.S (length (order c))) by apply side_length.
  assert (LRS : length rs = Datatypes.S (length (order c))) by (unfold rs; rewrite side_length,
    rev_length; reflexivity).
  exists (nth (length left) ls 0), (nth (length right) rs 0). split; [exact B1|].
  split; [eapply bounds_perm; [apply Permutation_sym, Permutation_rev|exact B2]|].
  assert (LO : length (order c) = (length left + length right)%nat) by (rewrite E, app_length; reflexivity).
  assert (H := check_cuts_spec _ _ _ _ _ _ _ _ _ _ C).
  assert (Q : bound <= nth (length left) ls 0 + nth (length left) (rev rs) 0 + penalty r).
  { apply (H ltac:(lia) ltac:(rewrite rev_length; lia) left s l2 edge).
    - rewrite E, ER. reflexivity.
    - rewrite EL, last_key_snoc, K. reflexivity.
    - congruence.
    - lia. }
  rewrite rev_nth in Q by lia. rewrite LRS, LO in Q.
  replace (Datatypes.S (length left + length right) - Datatypes.S (length left))%nat with (length right) in Q by lia.
    lia.
Qed.

Lemma check_columns_spec line depth bound all v : forall cs, check_columns r line depth bound all cs = Ok v ->
  v = bound /\ forall c, In c cs -> exists v', check_column r line depth bound all c = Ok v'.
Proof.
  induction cs as [|c cs IH]; simpl; intros H; [injection H as <-; split; [auto|tauto]|].
  destruct (check_column r line depth bound all c) as [v'|] eqn:E; [|discriminate].
  destruct (IH H) as [V I]. split; [exact V|]. intros c' [<-|J]; eauto.
Qed.

(** A threshold that leaves samples on both sides is a cut. *)
Lemma threshold_cut c th order : StronglySorted (key_le c) order -> lower c th order <> [] -> upper c th order <> [] ->
  exists edge, is_cut c order (lower c th order) edge (upper c th order).
Proof.
  intros SS NL NU. destruct (exists_last NL) as (l & x & E). exists (key c x). split; [apply sorted_parts, SS|].
  split; [exists l, x; auto|]. destruct (upper c th order) as [|s u] eqn:U; [congruence|]. exists s, u.
    split; [reflexivity|].
  assert (A : key c x <= th) by (apply (lower_keys c th order); rewrite E; apply in_elt).
  assert (B : th < key c s) by (apply (upper_keys c th order); rewrite U; simpl; auto). lia.
Qed.

Lemma columns_cuts line d bound all v samples cs :
  all_sound r samples -> are_columns d samples cs -> bounds r d samples all ->
  check_columns r line (S d) bound all cs = Ok v -> cuts_bound r d samples bound.
Proof.
  intros S [F C] A H c th R W1 W2. destruct (check_columns_spec _ _ _ _ _ _ H) as [_ I].
  destruct (C c R) as (col & J & E). destruct (I col J) as (v' & V). rewrite Forall_forall in F.
  assert (COL := F col J). destruct COL as [[P SS] SV]. rewrite E in SS.
  assert (PL : Permutation (lower c th (order col)) (lower c th samples)) by (apply Permutation_sym, filter_perm, P).
  assert (PU : Permutation (upper c th (order col)) (upper c th samples)) by (apply Permutation_sym, filter_perm, P).
  assert (NL := Permutation_length PL). assert (NU := Permutation_length PU).
  destruct (threshold_cut c th (order col) SS) as (edge & CUT);
    [intros Z0; rewrite Z0 in NL; simpl in NL; lia|intros Z0; rewrite Z0 in NU; simpl in NU; lia|].
  rewrite <- E in CUT at 1.
  destruct (check_column_spec _ _ _ _ _ _ _ S (F col J) A V _ _ _ CUT) as (b1 & b2 & B1 & B2 & B); [lia|lia|].
  exists b1, b2. split; [eapply bounds_perm; eauto|]. split; [eapply bounds_perm; eauto|exact B].
Qed.

(** * Records whose sides are counted *)

Definition pairs_of (all : list column) : list (nat * list sample) := map (fun c => (index c, order c)) all.

Lemma pairs_orders d samples all : are_columns d samples all -> all_orders r samples (pairs_of all).
Proof.
  intros [F C]. split.
  - rewrite Forall_forall in *. intros o I. apply in_map_iff in I. destruct I as (c & <- & I).
    destruct (F c I) as [O _]. exact O.
  - intros c R. destruct (C c R) as (col & I & <-). exists (order col). apply in_map_iff. exists col. auto.
Qed.

Lemma runs_of_pairs place all :
  runs_of place all = map (fun o => run_of place (fst o) (snd o)) (pairs_of all).
Proof. unfold runs_of, pairs_of. rewrite map_map. reflexivity. Qed.

Lemma stumps_of_spec d place is_low samples all edges : all_sound r samples -> are_columns d samples all ->
  Forall2 (fun edge b => bounds r 1 (part_of place edge is_low samples) b) edges
    (stumps_of r place samples (runs_of place all) is_low edges).
Proof.
  intros S A. unfold stumps_of. rewrite runs_of_pairs.
  apply (stumps_spec r penalty_nonneg leaf_size_pos place is_low samples (pairs_of all) edges S (pairs_orders _ _ _ A)).
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

Lemma Forall2_rev_l (A B : Type) (P : A -> B -> Prop) l m : Forall2 P (rev l) m -> Forall2 P l (rev m).
Proof.
  revert m. induction l as [|x l IH]; intros m H; simpl in H.
  - inversion H; subst. constructor.
  - apply Forall2_app_inv_l in H. destruct H as (m1 & m2 & H1 & H2 & ->). inversion H2 as [|? y ? ? Q T]; subst.
    inversion T; subst. rewrite rev_app_distr. simpl. constructor; auto.
Qed.

Lemma solve_all_column samples : forall cuts left right c,
  is_column 1 samples c ->
  (forall cut, In cut cuts -> exists l l', is_cut (index c) (order c) l (snd cut) l' /\ Z.of_nat (length l) = fst cut)
    ->
  Forall2 (fun edge b => bounds r 1 (part_of (key (index c)) edge true samples) b) (map snd cuts) left ->
  Forall2 (fun edge b => bounds r 1 (part_of (key (index c)) edge false samples) b) (map snd cuts) right ->
  is_column 1 samples (solve_all c cuts left right) /\ index (solve_all c cuts left right) = index c.
Proof.
  induction cuts as [|[place edge] cuts IH]; intros left right c C K L R; simpl; [auto|].
  simpl in L, R. inversion L as [|? b1 ? ? L0 L1]; subst. inversion R as [|? b2 ? ? R0 R1]; subst.
  destruct (K (place, edge)) as (lo & hi & CUT & N); [simpl; auto|]. simpl in CUT, N.
  assert (COL := C). destruct COL as [[P SS] SV].
  destruct (cut_parts _ _ _ _ _ SS CUT) as [EL ER].
  assert (PL : Permutation (part_of (key (index c)) edge true samples) lo) by (rewrite <- EL; apply filter_perm, P).
  assert (PR : Permutation (part_of (key (index c)) edge false samples) hi) by (rewrite <- ER; apply filter_perm, P).
  apply (IH _ _ (solve_cut c place (b1, b2))); auto.
  - eapply solve_cut_column; eauto; eapply bounds_perm; eauto.
  - intros cut I. apply K. simpl. auto.
Qed.

Lemma count_records_spec samples : forall records all all', all_sound r samples -> are_columns 1 samples all ->
  count_records r samples all records = Ok all' -> are_columns 1 samples all'.
Proof.
  induction records as [|[line i steps] records IH]; intros all all' S A H; simpl in H; [injection H as <-; exact A|].
  destruct (column_of i all) as [c|] eqn:E.
  - destruct (column_of_spec _ _ _ E) as [I <-].
    destruct (read_cuts line (index c) steps 0 None (order c) []) as [cuts|] eqn:R; [|discriminate].
    assert (K := read_cuts_spec _ _ _ _ _ _ _ _ [] R eq_refl eq_refl (fun cut I => match I with end)).
    assert (COL : is_column 1 samples c) by (destruct A as [F _]; rewrite Forall_forall in F; auto).
    eapply IH; [exact S| |exact H].
    assert (Q : is_column 1 samples (count_cuts r samples (runs_of (key (index c)) all) c cuts));
      [|apply replace_columns; auto].
    unfold count_cuts. rewrite !rev'_rev. apply solve_all_column; auto.
    + apply Forall2_rev_l. eapply stumps_of_spec; eauto.
    + eapply stumps_of_spec; eauto.
  - destruct steps as [|[distance sides] steps]; [|discriminate]. eapply IH; eauto.
Qed.

(** * Records whose sides are proven *)

Definition has_orders (samples : list sample) (all : list column) : Prop :=
  Forall (is_order samples) all /\ covers all.

Lemma columns_orders d samples all : are_columns d samples all -> has_orders samples all.
Proof. intros [F C]. split; [|exact C]. eapply Forall_impl; [|exact F]. intros c [O _]. exact O. Qed.

Lemma part_fresh samples all i edge is_low : has_orders samples all ->
  is_fresh (part_of (key i) edge is_low samples) (columns_of i edge is_low all).
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
Hypothesis below : forall samples all proof b, all_sound r samples -> is_fresh samples all ->
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
  is_column d samples c -> order c = before ++ rest -> behind (index c) before last ->
  Z.of_nat (length before) = place ->
  solve_cuts check_below line samples all c steps place last rest = Ok c' ->
  is_column d samples c'.
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

Lemma solve_records_spec samples : all_sound r samples -> forall records all all', are_columns d samples all ->
  solve_records check_below samples all records = Ok all' -> are_columns d samples all'.
Proof.
  intros S. induction records as [|[line i steps] records IH]; intros all all' A H; simpl in H; [injection H as <-;
    exact A|].
  destruct (column_of i all) as [c|] eqn:E.
  - destruct (column_of_spec _ _ _ E) as [I <-].
    destruct (solve_cuts check_below line samples all c steps 0 None (order c)) as [c'|] eqn:R; [|discriminate].
    assert (COL : is_column d samples c) by (destruct A as [F _]; rewrite Forall_forall in F; auto).
    eapply IH; [|exact H]. apply replace_columns; auto.
    apply (solve_cuts_spec line samples all S (columns_orders _ _ _ A) steps c 0 None (order c) [] c'); auto.
    reflexivity.
  - destruct steps as [|[distance sides] steps]; [|discriminate]. eapply IH; eauto.
Qed.

Lemma solve_below_spec samples all of_all records b all' : all_sound r samples -> is_fresh samples all ->
  solve_below check_below samples all of_all records = Ok (b, all') ->
  bounds r d samples b /\ are_columns d samples all'.
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
Lemma count_below_spec samples all records b all' : all_sound r samples -> is_fresh samples all ->
  count_below r samples all records = Ok (b, all') -> bounds r 1 samples b /\ are_columns 1 samples all'.
Proof.
  intros S F H. unfold count_below in H.
  destruct (count_records r samples all records) as [all0|] eqn:E; [|discriminate]. injection H as <- <-.
  assert (A := count_records_spec _ _ _ _ S (fresh_columns 1 _ _ S F) E). split; [|exact A].
  assert (H := stumps_of_spec 1 (fun _ => 0) true samples all [0] S (fresh_columns 1 _ _ S F)).
  destruct (stumps_of _ _ _ _ _ _) as [|b rest]; inversion H as [|? ? ? ? B _]; subst.
  simpl. unfold part_of in B. rewrite filter_all in B by reflexivity. exact B.
Qed.

Lemma one_leaf_spec samples b : all_sound r samples -> b <= one_leaf samples -> leaf_bounds r samples b.
Proof.
  intros S B. unfold one_leaf in B. rewrite sums_spec in B. apply leaf_cost; auto.
Qed.

(** What [check_node] accepts is true. *)
Theorem check_node_spec : forall depth samples all proof b, all_sound r samples -> is_fresh samples all ->
  check_node r depth samples all proof = Ok b -> bounds r depth samples b.
Proof.
  induction depth as [|depth IH]; intros samples all proof b S F H;
    destruct proof as [line|line levels leaf bound of_all records fault];
    try discriminate.
  cbn [check_node] in H. unfold ensure in H.
  destruct (_ && _) in H; [|discriminate].
  destruct (Nat.leb (Datatypes.S depth) 2) eqn:D2.
  - destruct (count_below r samples all records) as [[b1 all']|] eqn:E; [|discriminate].
    destruct (count_below_spec _ _ _ _ _ S F E) as [B A].
    destruct fault; [discriminate|].
    destruct (Nat.eqb_spec (Datatypes.S depth) 1) as [D1|D1].
    + injection D1 as ->. destruct (Z.leb_spec bound b1); [|discriminate]. injection H as <-.
      eapply bounds_le; eauto.
    + apply Nat.leb_le in D2. assert (depth = 1%nat) by lia. subst depth.
      destruct (Z.leb_spec bound (one_leaf samples)) as [L|]; [|discriminate].
      destruct (check_columns_spec _ _ _ _ _ _ H) as [-> _].
      apply Inequalities.node; [apply one_leaf_spec; auto|eapply columns_cuts; eauto].
  - destruct (solve_below (check_node r depth) samples all of_all records) as [[b1 all']|] eqn:E; [|discriminate].
    destruct (solve_below_spec depth _ IH _ _ _ _ _ _ S F E) as [B A].
    destruct fault; [discriminate|].
    destruct (Nat.eqb_spec (Datatypes.S depth) 1) as [D1|D1]; [injection D1 as ->; discriminate|].
    destruct (Z.leb_spec bound (one_leaf samples)) as [L|]; [|discriminate].
    destruct (check_columns_spec _ _ _ _ _ _ H) as [-> _].
    apply Inequalities.node; [apply one_leaf_spec; auto|eapply columns_cuts; eauto].
Qed.

End Rules.
