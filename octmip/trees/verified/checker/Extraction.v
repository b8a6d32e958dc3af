(** The checker as an OCaml program: whole numbers of Coq are those of the library Zarith ([program/integer.ml]), pairs,
    lists, options and booleans those of OCaml. What is written between quotation marks is trusted. *)

From Coq Require Import ZArith List Extraction.
From octmip Require Import Specification Checker Whole Cases.

Extraction Language OCaml.
Set Extraction Optimize.

Extract Inductive bool => "bool" [ "true" "false" ].
Extract Inductive option => "option" [ "Some" "None" ].
Extract Inductive list => "list" [ "[]" "(::)" ].
Extract Inductive prod => "( * )" [ "(,)" ].
Extract Inductive comparison => "int" [ "0" "(-1)" "1" ]
  "(fun equal less greater c -> if c = 0 then equal () else if c < 0 then less () else greater ())".
Extract Inlined Constant andb => "(&&)".
Extract Inlined Constant orb => "(||)".
Extract Inlined Constant negb => "not".

Extract Inductive positive => "Integer.t"
  [ "(fun p -> Integer.succ (Integer.shift_left p 1))" "(fun p -> Integer.shift_left p 1)" "Integer.one" ]
  "(fun odd even one p -> if Integer.equal p Integer.one then one () else if Integer.is_odd p then odd (Integer.shift_right p 1) else even (Integer.shift_right p 1))".
Extract Inductive Z => "Integer.t" [ "Integer.zero" "(fun p -> p)" "Integer.neg" ]
  "(fun zero positive negative z -> let s = Integer.sign z in if s = 0 then zero () else if s > 0 then positive z else negative (Integer.neg z))".
Extract Inlined Constant Z.add => "Integer.add".
Extract Inlined Constant Z.sub => "Integer.sub".
Extract Inlined Constant Z.mul => "Integer.mul".
Extract Inlined Constant Z.land => "Integer.logand".
Extract Inlined Constant Z.shiftr => "Integer.shifted_right".
Extract Inlined Constant Z.opp => "Integer.neg".
Extract Inlined Constant Z.min => "Integer.min".
Extract Inlined Constant Z.max => "Integer.max".
Extract Inlined Constant Z.eqb => "Integer.equal".
Extract Inlined Constant Z.leb => "Integer.leq".
Extract Inlined Constant Z.ltb => "Integer.lt".

Extraction "verified.ml" check.
