(** Samples as the checker counts them, and sums over lists of samples. *)

From Coq Require Import ZArith List Bool.
Import ListNotations.
Open Scope Z_scope.

(** A sample: its key in each column (it goes left of a cut if the key is at most the threshold), what each label costs,
    and what the checker makes of these costs.

    - [worst]: no label costs more.
    - [gains]: by label, what it saves of [worst]; labels beyond the list save nothing.
    - [reach]: no label saves more.
    - [sure]: every label costs as much.
    - [more]: by label; a label costs [sure] and the [more] of every other label.
    - [packed]: the gains in one number, [width] bits each. *)
Record sample := Sample {
  keys : list Z;
  prices : list Z;
  worst : Z;
  gains : list Z;
  reach : Z;
  sure : Z;
  more : list Z;
  width : Z;
  packed : Z
}.

Definition key (column : nat) (s : sample) : Z := nth column (keys s) 0.
Definition price (label : nat) (s : sample) : Z := nth label (prices s) 0.
Definition gain (label : nat) (s : sample) : Z := nth label (gains s) 0.

(** A sum over samples. *)
Fixpoint total (what : sample -> Z) (samples : list sample) : Z :=
  match samples with
  | [] => 0
  | s :: rest => what s + total what rest
  end.

(** Vectors: entries beyond the end are 0. *)
Fixpoint add (u v : list Z) : list Z :=
  match v with
  | [] => u
  | y :: v' => match u with [] => v | x :: u' => x + y :: add u' v' end
  end.

Fixpoint sum (v : list Z) : Z :=
  match v with [] => 0 | x :: v' => x + sum v' end.

(** The sum of the entries whose places are not among [places]. *)
Definition has (places : list nat) (place : nat) : bool := existsb (Nat.eqb place) places.
Definition beyond_first (places : list nat) : list nat :=
  map Nat.pred (filter (fun place => negb (Nat.eqb place 0)) places).
Fixpoint outside (places : list nat) (v : list Z) : Z :=
  match v with
  | [] => 0
  | x :: v' => (if has places 0 then 0 else x) + outside (beyond_first places) v'
  end.

(** The largest entry, 0 at least. *)
Fixpoint top (v : list Z) : Z :=
  match v with [] => 0 | x :: v' => Z.max x (top v') end.

(** The largest difference of entries of two vectors, 0 at least. *)
Fixpoint top_gap (u v : list Z) : Z :=
  match u with
  | [] => 0
  | x :: u' => match v with [] => top u | y :: v' => Z.max (x - y) (top_gap u' v') end
  end.

(** Vectors in one number, so that one addition adds them: the entries as digits of base [2 ^ its_width]. *)
Fixpoint pack (its_width : Z) (v : list Z) : Z :=
  match v with [] => 0 | x :: v' => x + pack its_width v' * 2 ^ its_width end.

(** [top gone + top_gap all gone] of two packed vectors of [n] entries; [mask] is [2 ^ its_width - 1]. *)
Fixpoint saved (n : nat) (its_width mask all gone most most_gap : Z) : Z :=
  match n with
  | O => most + most_gap
  | S n' =>
      let x := Z.land gone mask in
      saved n' its_width mask (Z.shiftr all its_width) (Z.shiftr gone its_width)
        (Z.max most x) (Z.max most_gap (Z.land all mask - x))
  end.

(** A vector without its zeros at the end. *)
Definition trimmed (v : list Z) : list Z :=
  fold_right (fun x rest => match rest with [] => if x =? 0 then [] else [x] | _ => x :: rest end) [] v.

(** The smallest entry, of those at other places than [but]; none of an empty list. *)
Fixpoint least (v : list Z) : option Z :=
  match v with
  | [] => None
  | x :: v' => match least v' with None => Some x | Some y => Some (Z.min x y) end
  end.
Fixpoint without (place : nat) (v : list Z) : list Z :=
  match v, place with
  | [], _ => []
  | _ :: v', O => v'
  | x :: v', S place' => x :: without place' v'
  end.
Definition or_zero (v : option Z) : Z := match v with Some x => x | None => 0 end.

(** A sample from its keys, its prices and the label that is thought to be the right one. *)
Definition sample_of (its_width : Z) (its_keys its_prices : list Z) (favourite : nat) : sample :=
  let most := top its_prices in
  let cheapest := or_zero (least its_prices) in
  let extra := or_zero (least (without favourite its_prices)) - cheapest in
  let its_gains := trimmed (map (fun x => most - x) its_prices) in
  {| keys := its_keys; prices := its_prices; worst := most; gains := its_gains;
     reach := most - cheapest; sure := cheapest;
     more := if extra <=? 0 then [] else repeat 0 favourite ++ [extra];
     width := its_width; packed := pack its_width its_gains |}.
