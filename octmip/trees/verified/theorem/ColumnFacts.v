(** Columns of the samples of a node, and their cuts, which are solved one after the other. *)

From Coq Require Import ZArith List Bool Permutation Sorting.Sorted Lia Arith.
Import ListNotations.
From octmip Require Import Samples Sums Trees Inequalities Stumps BlockFacts StumpFacts SideFacts Checker.
Open Scope Z_scope.
Local Arguments Z.add : simpl never.
Local Arguments Z.sub : simpl never.
Local Arguments Z.mul : simpl never.

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

(** * Columns *)

Section Rules.
Variable r : rules.
Hypothesis penalty_nonneg : 0 <= penalty r.
Hypothesis leaf_size_pos : (1 <= leaf_size r)%nat.

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

End Rules.
