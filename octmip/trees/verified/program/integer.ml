(* Whole numbers of any length, under a name that the extracted program does not use for a module of its own. Additions
   and comparisons of numbers of one machine word are done in place: they are most of the work. *)

module Words = struct
  let is_word (x : Z.t) = Obj.is_int (Obj.repr x)
  let word (x : Z.t) : int = Obj.magic x

  (* A sum has overflown if its sign is neither that of one part nor that of the other. *)
  let add x y =
    if is_word x && is_word y then
      let sum = word x + word y in
      if (word x lxor sum) land (word y lxor sum) >= 0 then (Obj.magic sum : Z.t) else Z.add x y
    else Z.add x y

  let sub x y =
    if is_word x && is_word y then
      let difference = word x - word y in
      if (word x lxor word y) land (word x lxor difference) >= 0 then (Obj.magic difference : Z.t) else Z.sub x y
    else Z.sub x y

  let logand x y = if is_word x && is_word y then (Obj.magic (word x land word y) : Z.t) else Z.logand x y

  (* Division by a power of two, rounded down. *)
  let shifted_right x n =
    if is_word x && is_word n && 0 <= word n && word n < 63 then (Obj.magic (word x asr word n) : Z.t)
    else Z.shift_right x (Z.to_int n)

  let leq x y = if is_word x && is_word y then word x <= word y else Z.leq x y
  let lt x y = if is_word x && is_word y then word x < word y else Z.lt x y
  let equal x y = if is_word x && is_word y then word x = word y else Z.equal x y
  let max x y = if leq x y then y else x
  let min x y = if leq x y then x else y
end

include Z
include Words
