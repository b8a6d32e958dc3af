(** Bounds of the two sides of every cut of a column, from the few cuts that are solved. *)

From Coq Require Import ZArith List Bool.
Import ListNotations.
From octmip Require Import Samples.
Open Scope Z_scope.

(** For 0, 1, ... [c] places left out: the smallest sum of the other entries. [c] is the length of [zeros], less 1. *)
Fixpoint leave_out (x previous : Z) (sums : list Z) : list Z :=
  match sums with [] => [] | y :: rest => Z.min (x + y) previous :: leave_out x y rest end.
Fixpoint least_sums (zeros : list Z) (v : list Z) : list Z :=
  match v with
  | [] => zeros
  | x :: v' => match least_sums zeros v' with [] => [] | y :: rest => x + y :: leave_out x y rest end
  end.

(** How many labels a tree of [depth] levels gives at most; none if it may give all. *)
Definition label_count (n_labels depth : nat) : option nat :=
  if Z.of_nat n_labels <=? 2 ^ Z.of_nat depth then None else Some (2 ^ depth)%nat.

(** What samples cost at least by their labels alone, if their [more] add up to [joined]. *)
Definition spread (count : option nat) (joined : list Z) : Z :=
  match count with None => 0 | Some c => last (least_sums (repeat 0 (S c)) joined) 0 end.

(** All sets of so many of some labels. *)
Fixpoint subsets (size : nat) (labels : list nat) : list (list nat) :=
  match labels, size with
  | [], _ | _, O => [[]]
  | label :: rest, S size' =>
      if Nat.leb (length labels) size then [labels] else subsets size rest ++ map (cons label) (subsets size' rest)
  end.

(** Whether there are no more than 64 of them. *)
Definition are_few (n size : nat) : bool :=
  let next := fun sets i => if 64 <? sets then sets else sets * Z.of_nat (n - i) / Z.of_nat (S i) in
  fold_left next (seq 0 (Nat.min size (n - size))) 1 <=? 64.

(** The sets of labels that a tree of [depth] levels may give, if they are gone through. *)
Definition label_sets (is_wanted : bool) (n_labels depth : nat) : list (list nat) :=
  match label_count n_labels depth with
  | Some count => if is_wanted && are_few n_labels count then subsets count (seq 0 n_labels) else []
  | None => []
  end.

(** What a sample costs at least under each set. *)
Definition set_costs (sets : list (list nat)) (s : sample) : list Z :=
  map (fun set => or_zero (least (map (fun label => price label s) set))) sets.

(** Growing: bounds of the first 0, 1, ... samples of an order. [known] are the bounds of solved cuts by the number of
    samples, from 1 to all but one, and [bound_of_all] is that of all. The first samples cost [before] by a solved cut,
    those that joined since then [surely] and their spread, or the least under a set of labels. *)
Fixpoint grow (count : option nat) (sets : list (list nat)) (may_grow : bool) (bound_of_all : Z)
    (rest : list sample) (known : list Z) (now before surely : Z) (joined by_set : list Z)
    : list Z :=
  now ::
  match rest with
  | [] => []
  | s :: rest' =>
      let own := match rest' with [] => bound_of_all | _ => match known with [] => 0 | b :: _ => b end end in
      let joined' := add joined (more s) in
      let surely' := surely + sure s in
      let by_set' := add by_set (set_costs sets s) in
      let grown := before + Z.max (surely' + spread count joined') (or_zero (least by_set')) in
      if may_grow && (grown <? own)
      then grow count sets may_grow bound_of_all rest' (tl known) own own 0 [] []
      else grow count sets may_grow bound_of_all rest' (tl known) (Z.max grown own) before surely' joined' by_set'
  end.

(** Shrinking: each bound is raised to the next one, less what the sample between them costs at most. *)
Fixpoint shrink (rest : list sample) (bounds : list Z) : list Z :=
  match bounds, rest with
  | b :: bounds', s :: rest' =>
      match shrink rest' bounds' with
      | [] => [b]
      | next :: others => Z.max b (next - worst s) :: next :: others
      end
  | _, _ => bounds
  end.

Definition side (count : option nat) (sets : list (list nat)) (may_grow : bool) (order : list sample) (known : list Z)
    (bound_of_all : Z) : list Z :=
  shrink order (grow count sets may_grow bound_of_all order known 0 0 0 [] []).
