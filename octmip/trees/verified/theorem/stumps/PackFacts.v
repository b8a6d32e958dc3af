(** Vectors packed in one number: sums of them are sums of the vectors, and a look at them finds what a cut saves. *)

From Coq Require Import ZArith List Bool Lia Arith.
Import ListNotations.
From octmip Require Import Samples Sums.
Open Scope Z_scope.
Local Arguments Z.add : simpl never.
Local Arguments Z.sub : simpl never.
Local Arguments Z.mul : simpl never.

(** What a cut saves. *)
Definition saving (all gone : list Z) : Z := top gone + top_gap all gone.

Lemma top_gap_of_none all : top_gap all [] = top all.
Proof. destruct all; reflexivity. Qed.

Section Width.
Variable w : Z.
Hypothesis w_nonneg : 0 <= w.

Lemma pack_add u : forall v, pack w (add u v) = pack w u + pack w v.
Proof.
  induction u as [|x u IH]; intros [|y v]; cbn [add pack]; try lia. rewrite IH. lia.
Qed.

Definition digits (v : list Z) : Prop := Forall (fun x => 0 <= x < 2 ^ w) v.

Lemma low_digit x z : 0 <= x < 2 ^ w -> Z.land (x + z * 2 ^ w) (2 ^ w - 1) = x.
Proof.
  intros D. replace (2 ^ w - 1) with (Z.ones w) by (rewrite Z.ones_equiv; lia).
  rewrite Z.land_ones by exact w_nonneg. rewrite Z.mod_add by lia. apply Z.mod_small, D.
Qed.

Lemma other_digits x z : 0 <= x < 2 ^ w -> Z.shiftr (x + z * 2 ^ w) w = z.
Proof.
  intros D. rewrite Z.shiftr_div_pow2 by exact w_nonneg. rewrite Z.div_add by lia. rewrite Z.div_small by exact D. lia.
Qed.

Lemma saved_spec : forall n u v m1 m2, digits u -> digits v -> (length u <= n)%nat -> (length v <= n)%nat ->
  0 <= m1 -> 0 <= m2 ->
  saved n w (2 ^ w - 1) (pack w u) (pack w v) m1 m2 = Z.max m1 (top v) + Z.max m2 (top_gap u v).
Proof.
  assert (P : 0 < 2 ^ w) by (apply Z.pow_pos_nonneg; lia).
  induction n as [|n IH]; intros u v m1 m2 U V LU LV M1 M2.
  - destruct u, v; simpl in LU, LV; try lia. simpl. lia.
  - cbn [saved].
    assert (E : forall z, digits z -> (length z <= S n)%nat -> exists x z',
      0 <= x < 2 ^ w /\ pack w z = x + pack w z' * 2 ^ w /\ digits z' /\ (length z' <= n)%nat /\
      (z = x :: z' \/ (z = [] /\ x = 0 /\ z' = []))).
    { intros [|x z'] D L; [exists 0, []|exists x, z'].
      - split; [lia|]. split; [cbn [pack]; lia|]. split; [constructor|]. split; [simpl; lia|]. right. auto.
      - inversion D; subst. simpl in L. split; [assumption|]. split; [reflexivity|]. split; [assumption|].
        split; [lia|]. left. reflexivity. }
    destruct (E u U LU) as (x & u' & X & -> & U' & LU' & CU). destruct (E v V LV) as (y & v' & Y & -> & V' & LV' & CV).
    rewrite !low_digit, !other_digits by assumption. rewrite IH by (auto; lia).
    destruct CU as [->|(-> & -> & ->)], CV as [->|(-> & -> & ->)]; cbn [top top_gap];
      rewrite ?top_gap_of_none; cbn [top];
      try (assert (T := top_nonneg v')); try (assert (T' := top_nonneg u')); lia.
Qed.

End Width.

(** * Samples *)

Lemma add_length u : forall v, length (add u v) = Nat.max (length u) (length v).
Proof. induction u as [|x u IH]; intros [|y v]; simpl; auto. Qed.

Section Samples.
Variable n : nat.
Variable w : Z.
Hypothesis w_nonneg : 0 <= w.

(** Samples that are packed alike. *)
Definition packs (s : sample) : Prop := sound n s /\ width s = w.

Lemma packs_sound l : Forall packs l -> Forall (sound n) l.
Proof. apply Forall_impl. unfold packs. tauto. Qed.

Lemma joined_length l : Forall packs l -> forall v, (length v <= n)%nat -> (length (joined gains l v) <= n)%nat.
Proof.
  induction 1 as [|s l [S _] F IH]; intros v L; [exact L|]. apply (IH (add v (gains s))). rewrite add_length.
  assert (G := gains_length n s S). lia.
Qed.

Lemma joined_packed l : Forall packs l -> forall v, pack w (joined gains l v) = pack w v + total packed l.
Proof.
  induction 1 as [|s l [S E] F IH]; intros v; [simpl; lia|]. unfold joined in *. cbn [fold_left total].
  rewrite IH, pack_add, (packed_gains n s S), E. lia.
Qed.

Lemma reach_nonneg l : Forall (sound n) l -> 0 <= total reach l.
Proof.
  intros S. apply total_nonneg. intros s I. rewrite Forall_forall in S.
  assert (G := gain_range n s (S s I) 0%nat). lia.
Qed.

Lemma joined_digits l : Forall packs l -> total reach l < 2 ^ w -> digits w (joined gains l []).
Proof.
  intros F R. apply Forall_forall. intros x I. destruct (In_nth _ _ 0 I) as (i & _ & <-).
  rewrite nth_joined, nth_nil. apply packs_sound in F. rewrite Forall_forall in F.
  assert (A : 0 <= total (fun s => nth i (gains s) 0) l).
  { apply total_nonneg. intros s J. apply (gain_range n s (F s J) i). }
  assert (B : total (fun s => nth i (gains s) 0) l <= total reach l).
  { apply total_le. intros s J. apply (gain_range n s (F s J) i). }
  lia.
Qed.

(** A look at packed sums finds what the cut saves. *)
Theorem saved_packed all gone : Forall packs all -> Forall packs gone ->
  total reach all < 2 ^ w -> total reach gone < 2 ^ w ->
  saved n w (2 ^ w - 1) (total packed all) (total packed gone) 0 0
    = saving (joined gains all []) (joined gains gone []).
Proof.
  intros A G RA RG. assert (PA := joined_packed all A []). assert (PG := joined_packed gone G []).
  simpl in PA, PG. rewrite Z.add_0_l in PA, PG. rewrite <- PA, <- PG.
  rewrite saved_spec; try lia; try (apply joined_digits; assumption);
    try (apply joined_length; [assumption|simpl; lia]).
  unfold saving. assert (T := top_nonneg (joined gains gone [])).
  assert (T' := top_gap_nonneg (joined gains all []) (joined gains gone [])). lia.
Qed.

(** A sample that goes over changes what is saved by its reach at most. *)
Lemma saving_step s all gone : sound n s ->
  saving all (add gone (gains s)) <= saving all gone + reach s /\
  saving all gone <= saving all (add gone (gains s)) + reach s.
Proof.
  intros S. assert (G := gain_range n s S). unfold gain in G. unfold saving.
  assert (R : 0 <= reach s) by (specialize (G 0%nat); lia).
  assert (A : top gone <= top (add gone (gains s)) <= top gone + reach s).
  { assert (H := top_nonneg gone). assert (H' := top_nonneg (add gone (gains s))).
    split; (apply top_le; [lia|]); intros i.
    - assert (T := nth_le_top (add gone (gains s)) i). rewrite nth_add in T. specialize (G i). lia.
    - rewrite nth_add. assert (T := nth_le_top gone i). specialize (G i). lia. }
  assert (B : top_gap all (add gone (gains s)) <= top_gap all gone <= top_gap all (add gone (gains s)) + reach s).
  { assert (H := top_gap_nonneg all gone). assert (H' := top_gap_nonneg all (add gone (gains s))).
    split; (apply top_gap_le; [lia|]); intros i I.
    - rewrite nth_add. assert (T := nth_le_top_gap all gone i I). specialize (G i). lia.
    - assert (T := nth_le_top_gap all (add gone (gains s)) i I). rewrite nth_add in T. specialize (G i). lia. }
  lia.
Qed.

Lemma saving_steps all : forall l gone, Forall (sound n) l ->
  saving all (joined gains l gone) <= saving all gone + total reach l /\
  saving all gone <= saving all (joined gains l gone) + total reach l.
Proof.
  induction l as [|s l IH]; intros gone S; [unfold joined; simpl; lia|]. inversion S as [|? ? S0 S1]; subst.
  assert (A := saving_step s all gone S0). assert (B := IH (add gone (gains s)) S1). unfold joined in *. simpl. lia.
Qed.

End Samples.
