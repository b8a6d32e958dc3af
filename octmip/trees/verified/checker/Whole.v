(** The whole numbers of a log, each compared with the true cost. *)

From Coq Require Import ZArith List Bool.
Import ListNotations.
From octmip Require Import Specification Samples Columns Checker.
Open Scope Z_scope.

(** The numbers of a log: a table of costs, a row of it and a weight for each sample, a penalty. A unit of theirs is
    [up / down] of the question's. Besides, a row of a class costs [base] of that class at least, times its weight.
    [costs_line] and [penalty_line] are where they stand. *)
Record numbers := Numbers {
  table : list (list Z);
  its_rows : list nat;
  its_weights : list Z;
  its_penalty : Z;
  up : Z;
  down : Z;
  base : list Z;
  costs_line : Z;
  penalty_line : Z
}.

Definition base_of (w : numbers) (x : row) : Z := weight x * nth (class x) (base w) 0.

(** Whether no label costs more than it truly does; else the first that does. *)
Fixpoint first_above (q : question) (w : numbers) (x : row) (label : nat) (its_prices : list Z) : option nat :=
  match its_prices with
  | [] => None
  | p :: rest =>
      if (0 <=? p) && (p * up w + base_of w x * down w <=? loss q label x * down w)
      then first_above q w x (S label) rest
      else Some label
  end.

Definition prices_of (q : question) (costs_of_row : list Z) (its_weight : Z) : list Z :=
  map (fun label => its_weight * nth label costs_of_row 0) (seq 0 (n_classes q)).

(** So many bits that the gains of all samples fit in them. Whether they do is looked at where they are added. *)
Definition width_of (w : numbers) : Z :=
  Z.log2 (sum (map Z.abs (its_weights w)) * top (map top (table w))) + 1.

Fixpoint samples_of (its_width : Z) (q : question) (w : numbers) (all : list place) (i : nat)
    (xs : list row) (table_rows : list nat) (weights : list Z) : checked (list sample) :=
  match xs, table_rows, weights with
  | [], [], [] => Ok []
  | x :: xs', table_row :: table_rows', its_weight :: weights' =>
      let its_prices := prices_of q (nth table_row (table w) []) its_weight in
      match first_above q w x 0 its_prices with
      | Some label => Refused (costs_line w) (AboveTheTrueCost i label)
      | None =>
          match samples_of its_width q w all (S i) xs' table_rows' weights' with
          | Refused line why => Refused line why
          | Ok rest => Ok (sample_of its_width (keys_of all x) its_prices table_row :: rest)
          end
      end
  | _, _, _ => Refused (costs_line w) WrongLengths
  end.

(** Whether some row of the table, of the class of its place, has more prices than that of its own label and a higher one
    of all others. *)
Definition has_several_prices (costs_ : list (list Z)) : bool :=
  let is_plain := fun '(own, its_prices) =>
    let others := without own its_prices in
    (or_zero (least others) =? top others) && (nth own its_prices 0 <=? top others) in
  negb (forallb is_plain (combine (seq 0 (length costs_)) costs_)).

(** What the rows cost besides. *)
Fixpoint base_total (w : numbers) (xs : list row) : Z :=
  match xs with [] => 0 | x :: rest => base_of w x + base_total w rest end.

Definition is_penalty_below (q : question) (w : numbers) : bool :=
  (0 <=? its_penalty w) && (its_penalty w * up w <=? split_penalty q * down w) && (0 <=? up w) && (0 <? down w).

(** Leaves hold a sample at least, every feature that is allowed has a sensor, and no sensor costs less than nothing. *)
Definition is_proper (q : question) : bool :=
  Nat.leb 1 (fewest q) && Nat.leb (length (allowed q)) (length (sensors q)) && forallb (Z.leb 0) (sensor_costs q).
