(* Numbers of float64 as whole numbers, exactly. *)

(* Every finite float64 is a whole multiple of 2^-1074, every product of two one of 2^-2148. *)
let least_exponent = 1074

(* The number in units of 2^-1074. *)
let exact x =
  let mantissa, exponent = Float.frexp x in
  let whole = Z.of_float (Float.ldexp mantissa 53) in
  let shift = exponent - 53 + least_exponent in
  if shift >= 0 then Z.shift_left whole shift else Z.shift_right whole (-shift)

(* The largest float64 that is at most a number of 0 or more in units of 2^-2148. *)
let rounded_down units =
  let shift = max (Z.numbits units - 53) least_exponent in
  let x = Float.ldexp (Z.to_float (Z.shift_right units shift)) (shift - (2 * least_exponent)) in
  Float.min x Float.max_float

(* As few digits as come back the same, as Rust writes them. *)
let shown x =
  let digits = List.find (fun n -> float_of_string (Printf.sprintf "%.*e" n x) = x) (List.init 18 Fun.id) in
  let text = Printf.sprintf "%.*e" digits x in
  match String.split_on_char 'e' text with
  | [ mantissa; exponent ] when x <> 0.0 ->
      let exponent = int_of_float (float_of_string exponent) in
      if exponent < -5 || exponent > 15 then Printf.sprintf "%se%d" mantissa exponent
      else Printf.sprintf "%.*f" (max 0 (digits - exponent)) x
  | _ -> "0"
