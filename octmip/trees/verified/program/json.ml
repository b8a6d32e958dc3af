(* JSON as RFC 8259 has it, read strictly: every number finite, no key twice, no deep nesting. *)

type t = Null | Bool of bool | Number of float | Text of string | List of t list | Object of (string * t) list

exception Wrong of string

let most_depth = 32

type reader = { text : string; mutable at : int }

let wrong reader what =
  let line = ref 1 in
  String.iteri (fun i c -> if i < reader.at && c = '\n' then incr line) reader.text;
  raise (Wrong (Printf.sprintf "line %d: %s" !line what))

let rec peek r =
  if r.at >= String.length r.text then wrong r "the text ends within a value"
  else match r.text.[r.at] with ' ' | '\t' | '\n' | '\r' -> r.at <- r.at + 1; peek r | c -> c

let takes r mark =
  let is_next = peek r = mark in
  if is_next then r.at <- r.at + 1;
  is_next

let expect r mark = if not (takes r mark) then wrong r (Printf.sprintf "expected %C" mark)

let four_digits r =
  let is_hex c = match c with '0' .. '9' | 'a' .. 'f' | 'A' .. 'F' -> true | _ -> false in
  if r.at + 4 > String.length r.text then wrong r "expected four hexadecimal digits";
  let digits = String.sub r.text r.at 4 in
  if not (String.for_all is_hex digits) then wrong r "expected four hexadecimal digits";
  r.at <- r.at + 4;
  int_of_string ("0x" ^ digits)

(* The character of \uXXXX, of two of them where it takes a pair. *)
let unicode r =
  let first = four_digits r in
  let is_high = first >= 0xd800 && first < 0xdc00 in
  let is_pair = is_high && r.at + 2 <= String.length r.text && String.sub r.text r.at 2 = "\\u" in
  let code =
    if not is_pair then first
    else begin
      r.at <- r.at + 2;
      0x10000 + ((first - 0xd800) lsl 10) + (four_digits r - 0xdc00)
    end
  in
  if not (Uchar.is_valid code) || (is_pair && (code < 0x10000 || code > 0x10ffff)) then
    wrong r "half of a pair of \\u escapes";
  Uchar.of_int code

let string r =
  expect r '"';
  let out = Buffer.create 16 in
  let next () =
    if r.at >= String.length r.text then wrong r "the text ends within a string";
    r.at <- r.at + 1;
    r.text.[r.at - 1]
  in
  let rec go () =
    match next () with
    | '"' -> Buffer.contents out
    | '\\' ->
        (match next () with
        | ('"' | '\\' | '/') as c -> Buffer.add_char out c
        | 'b' -> Buffer.add_char out '\b'
        | 'f' -> Buffer.add_char out '\012'
        | 'n' -> Buffer.add_char out '\n'
        | 'r' -> Buffer.add_char out '\r'
        | 't' -> Buffer.add_char out '\t'
        | 'u' -> Buffer.add_utf_8_uchar out (unicode r)
        | _ -> wrong r "no escape that JSON knows");
        go ()
    | c when c < ' ' -> wrong r "a control character within a string"
    | c -> Buffer.add_char out c; go ()
  in
  go ()

(* A number in JSON's own grammar, which is narrower than OCaml's. *)
let number word =
  let n = String.length word in
  let rec digits i = if i < n && word.[i] >= '0' && word.[i] <= '9' then digits (i + 1) else i in
  let start = if n > 0 && word.[0] = '-' then 1 else 0 in
  let whole = digits start in
  let is_whole = whole > start && not (whole > start + 1 && word.[start] = '0') in
  let after_point = if whole < n && word.[whole] = '.' then digits (whole + 1) else whole in
  let is_fraction = after_point = whole || after_point > whole + 1 in
  let has_exponent = after_point < n && (word.[after_point] = 'e' || word.[after_point] = 'E') in
  let sign = after_point + 1 in
  let signed = if has_exponent && sign < n && (word.[sign] = '+' || word.[sign] = '-') then sign + 1 else sign in
  let ending = if has_exponent then digits signed else after_point in
  let is_exponent = (not has_exponent) || ending > signed in
  if is_whole && is_fraction && is_exponent && ending = n then
    let value = float_of_string word in
    if Float.is_finite value then Some value else None
  else None

let word r =
  let start = r.at in
  let is_of_word c =
    match c with '0' .. '9' | 'a' .. 'z' | 'A' .. 'Z' | '+' | '-' | '.' -> true | _ -> false
  in
  while r.at < String.length r.text && is_of_word r.text.[r.at] do r.at <- r.at + 1 done;
  match String.sub r.text start (r.at - start) with
  | "null" -> Null
  | "true" -> Bool true
  | "false" -> Bool false
  | word -> ( match number word with Some value -> Number value | None -> wrong r "no finite number or other value")

let rec value r depth =
  let first = peek r in
  if depth > most_depth then wrong r (Printf.sprintf "values are nested deeper than %d" most_depth);
  match first with
  | '[' -> expect r '['; if takes r ']' then List [] else list r depth []
  | '{' -> expect r '{'; if takes r '}' then Object [] else entries r depth (Hashtbl.create 16) []
  | '"' -> Text (string r)
  | _ -> word r

and list r depth values =
  let values = value r (depth + 1) :: values in
  if takes r ',' then list r depth values else (expect r ']'; List (List.rev values))

and entries r depth known found =
  ignore (peek r);
  let key = string r in
  if Hashtbl.mem known key then wrong r (Printf.sprintf "the key %S comes twice" key);
  Hashtbl.add known key ();
  expect r ':';
  let found = (key, value r (depth + 1)) :: found in
  if takes r ',' then entries r depth known found else (expect r '}'; Object (List.rev found))

let parse text =
  let r = { text; at = 0 } in
  let result = value r 0 in
  let is_blank c = match c with ' ' | '\t' | '\n' | '\r' -> true | _ -> false in
  if not (String.for_all is_blank (String.sub text r.at (String.length text - r.at))) then
    wrong r "more after the end of the value";
  result
