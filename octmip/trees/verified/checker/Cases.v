(** The cases of a proof under a budget, and the check of a whole log. *)

From Coq Require Import ZArith List Bool Orders Mergesort.
Import ListNotations.
From octmip Require Import Specification Samples Columns Trees Checker Whole.
Open Scope Z_scope.

(** Samples in the order of their keys. *)
Module KeyOrder <: TotalLeBool.
  Definition t := (Z * sample)%type.
  Definition leb (a b : t) : bool := fst a <=? fst b.
  Theorem leb_total : forall a b, leb a b = true \/ leb b a = true.
  Proof.
    intros a b. unfold leb. rewrite !Z.leb_le. apply Z.le_ge_cases.
  Qed.
End KeyOrder.
Module KeySort := Sort KeyOrder.

Definition sorted (column_ : nat) (samples : list sample) : list sample :=
  map snd (KeySort.sort (map (fun s => (key column_ s, s)) samples)).

(** What is decided of sensors: whether they are read. *)
Definition decisions := list (nat * bool).
Definition decided (sensor : nat) (ds : decisions) : option bool :=
  match find (fun d => Nat.eqb (fst d) sensor) ds with Some (_, is_read) => Some is_read | None => None end.

Fixpoint paid_so_far (q : question) (ds : decisions) : Z :=
  match ds with
  | [] => 0
  | (sensor, is_read) :: rest => (if is_read then nth sensor (sensor_costs q) 0 else 0) + paid_so_far q rest
  end.
Definition can_be_paid (q : question) (paid : Z) : bool :=
  match budget q with None => true | Some most => paid * (10 ^ 12 - 1) <=? most * 10 ^ 12 end.

(** Whether trees may read a sensor: one that cannot be paid for beside those that are read is not read either. *)
Definition may_read_sensor (q : question) (ds : decisions) (sensor : nat) : bool :=
  match decided sensor ds with
  | Some is_read => is_read
  | None => can_be_paid q (paid_so_far q ds + nth sensor (sensor_costs q) 0)
  end.

Definition may_read_place (q : question) (ds : decisions) (p : place) : bool :=
  nth (fst p) (allowed q) false && may_read_sensor q ds (sensor_of q (fst p)).
Definition may_read_column (q : question) (ds : decisions) (all : list place) (column_ : nat) : bool :=
  match nth_error all column_ with Some p => may_read_place q ds p | None => false end.

Definition rules_of (q : question) (w : numbers) (ds : decisions) (all : list place) : rules :=
  Rules (n_classes q) (fewest q) (its_penalty w) (may_read_column q ds all)
    (has_several_prices (table w)).

Definition columns_in_play (q : question) (ds : decisions) (all : list place) (samples : list sample) : list column :=
  map (fun column_ => unsolved column_ (sorted column_ samples))
    (filter (may_read_column q ds all) (seq 0 (length all))).

Definition line_of (proof : node) : Z :=
  match proof with Unreadable line => line | Node line _ _ _ _ _ _ => line end.

Fixpoint check_cases (q : question) (w : numbers) (all : list place) (samples : list sample) (claim : Z)
    (ds : decisions) (log : cases) : checked Z :=
  match log with
  | NoCase line => Refused line CannotBeRead
  | Case proof =>
      match
        check_node (rules_of q w ds all) (depth q) samples (columns_in_play q ds all samples) proof
      with
      | Refused line why => Refused line why
      | Ok bound => ensure (claim <=? bound) (line_of proof) (ProvesLess bound claim) (Ok claim)
      end
  | Decide line sensor unread read =>
      if (0 <=? sensor) && (sensor <? Z.of_nat (length (sensor_costs q)))
         && match decided (Z.to_nat sensor) ds with None => true | Some _ => false end
      then
        match check_cases q w all samples claim ((Z.to_nat sensor, false) :: ds) unread with
        | Refused line why => Refused line why
        | Ok _ => check_cases q w all samples claim ((Z.to_nat sensor, true) :: ds) read
        end
      else Refused line (NoSuchSensor sensor)
  end.

(** Check a log of a question: the bound that it proves is [value / down] in units of weight times cost. *)
Definition check (q : question) (w : numbers) (claim : Z) (log : cases) : checked Z :=
  let all := places (length (sensors q)) (rows q) in
  match samples_of (width_of w) q w all 0 (rows q) (its_rows w) (its_weights w) with
  | Refused line why => Refused line why
  | Ok samples =>
      ensure (is_penalty_below q w && is_proper q) (penalty_line w) PenaltyAbove
      match check_cases q w all samples claim [] log with
      | Refused line why => Refused line why
      | Ok _ => Ok (claim * up w + base_total w (rows q) * down w)
      end
  end.
