(** The columns of a question: a feature without missing readings is one; one with missing readings is two, in which the rows without a reading
    come first, or last. *)

From Coq Require Import ZArith List Bool.
Import ListNotations.
From octmip Require Import Specification Samples.
Open Scope Z_scope.

(** A column: its feature, and the key of a row without the reading. *)
Definition place := (nat * Z)%type.

Definition is_missing (x : option Z) : bool := match x with None => true | Some _ => false end.
Definition or_else (fill : Z) (x : option Z) : Z := match x with None => fill | Some value => value end.

Definition places_of (feature : nat) (values : list (option Z)) : list place :=
  if existsb is_missing values then
    let below := fold_right (fun x least => Z.min (or_else 0 x) least) 0 values in
    let above := fold_right (fun x most => Z.max (or_else 0 x) most) 0 values in
    [(feature, below - 1); (feature, above + 1)]
  else [(feature, 0)].

Definition places (n_features : nat) (xs : list row) : list place :=
  flat_map (fun feature => places_of feature (map (reading feature) xs)) (seq 0 n_features).

Definition keys_of (all : list place) (x : row) : list Z :=
  map (fun p => or_else (snd p) (reading (fst p) x)) all.
