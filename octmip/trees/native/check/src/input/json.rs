//! JSON as RFC 8259 has it, read strictly: every number finite, no key twice, no nesting that could exhaust the stack.

use std::iter::Peekable;
use std::str::CharIndices;

/// Deepest nesting that is read.
const MOST_DEPTH: usize = 32;

/// A JSON value.
#[derive(Debug, Clone, PartialEq)]
pub(crate) enum Json {
    /// `null`
    Null,
    /// `true` or `false`
    Bool(bool),
    /// A number, rounded once to float64.
    Number(f64),
    /// A string.
    Text(String),
    /// An array.
    List(Vec<Json>),
    /// An object, its entries in the order of the text.
    Object(Vec<(String, Json)>),
}

/// Read a text that is one JSON value; the error says where it is none.
pub(crate) fn parse(text: &str) -> Result<Json, String> {
    let mut reader = Reader { text, chars: text.char_indices().peekable() };
    let value = reader.value(0)?;
    reader.skip_blanks();
    match reader.chars.next() {
        None => Ok(value),
        Some((at, c)) => Err(reader.error(at, &format!("{c:?} after the end of the value"))),
    }
}

struct Reader<'a> {
    text: &'a str,
    chars: Peekable<CharIndices<'a>>,
}

impl Reader<'_> {
    fn error(&self, at: usize, what: &str) -> String {
        let line = self.text[..at].matches('\n').count() + 1;
        format!("line {line}: {what}")
    }

    fn skip_blanks(&mut self) {
        while self.chars.next_if(|&(_, c)| matches!(c, ' ' | '\t' | '\n' | '\r')).is_some() {}
    }

    fn peek(&mut self) -> Result<(usize, char), String> {
        self.skip_blanks();
        self.chars.peek().copied().ok_or_else(|| self.error(self.text.len(), "the text ends within a value"))
    }

    /// Take a mark if it comes next.
    fn takes(&mut self, mark: char) -> Result<bool, String> {
        let (_, c) = self.peek()?;
        if c == mark {
            self.chars.next();
        }
        Ok(c == mark)
    }

    fn expect(&mut self, mark: char) -> Result<(), String> {
        let (at, c) = self.peek()?;
        if self.takes(mark)? { Ok(()) } else { Err(self.error(at, &format!("got {c:?}, expected {mark:?}"))) }
    }

    fn value(&mut self, depth: usize) -> Result<Json, String> {
        let (at, c) = self.peek()?;
        if depth > MOST_DEPTH {
            return Err(self.error(at, &format!("values are nested deeper than {MOST_DEPTH}")));
        }
        match c {
            '[' => self.list(depth),
            '{' => self.object(depth),
            '"' => self.string().map(Json::Text),
            _ => self.word(at),
        }
    }

    fn list(&mut self, depth: usize) -> Result<Json, String> {
        self.expect('[')?;
        let mut values = Vec::new();
        if self.takes(']')? {
            return Ok(Json::List(values));
        }
        loop {
            values.push(self.value(depth + 1)?);
            if !self.takes(',')? {
                return self.expect(']').map(|()| Json::List(values));
            }
        }
    }

    fn object(&mut self, depth: usize) -> Result<Json, String> {
        self.expect('{')?;
        let mut entries: Vec<(String, Json)> = Vec::new();
        if self.takes('}')? {
            return Ok(Json::Object(entries));
        }
        loop {
            let (at, _) = self.peek()?;
            let key = self.string()?;
            if entries.iter().any(|(known, _)| *known == key) {
                return Err(self.error(at, &format!("the key {key:?} comes twice")));
            }
            self.expect(':')?;
            entries.push((key, self.value(depth + 1)?));
            if !self.takes(',')? {
                return self.expect('}').map(|()| Json::Object(entries));
            }
        }
    }

    fn string(&mut self) -> Result<String, String> {
        self.expect('"')?;
        let mut text = String::new();
        while let Some((at, c)) = self.chars.next() {
            match c {
                '"' => return Ok(text),
                '\\' => text.push(self.escape(at)?),
                c if c < ' ' => return Err(self.error(at, "a control character within a string")),
                c => text.push(c),
            }
        }
        Err(self.error(self.text.len(), "the text ends within a string"))
    }

    fn escape(&mut self, at: usize) -> Result<char, String> {
        let escaped = self.chars.next().map(|(_, c)| c);
        Ok(match escaped {
            Some(c @ ('"' | '\\' | '/')) => c,
            Some('b') => '\u{8}',
            Some('f') => '\u{c}',
            Some('n') => '\n',
            Some('r') => '\r',
            Some('t') => '\t',
            Some('u') => return self.unicode(at),
            _ => return Err(self.error(at, "no escape that JSON knows")),
        })
    }

    /// The character of `\uXXXX`, of two of them where it takes a pair.
    fn unicode(&mut self, at: usize) -> Result<char, String> {
        let first = self.four_digits(at)?;
        let code = if (0xd800..0xdc00).contains(&first) {
            let is_pair =
                self.chars.next().is_some_and(|(_, c)| c == '\\') && self.chars.next().is_some_and(|(_, c)| c == 'u');
            let second = if is_pair { self.four_digits(at)? } else { 0 };
            if !(0xdc00..0xe000).contains(&second) {
                return Err(self.error(at, "half of a pair of \\u escapes"));
            }
            0x10000 + ((first - 0xd800) << 10) + (second - 0xdc00)
        } else {
            first
        };
        char::from_u32(code).ok_or_else(|| self.error(at, "half of a pair of \\u escapes"))
    }

    fn four_digits(&mut self, at: usize) -> Result<u32, String> {
        let digits: Vec<Option<u32>> = (0..4).map(|_| self.chars.next().and_then(|(_, c)| c.to_digit(16))).collect();
        let code = digits.into_iter().try_fold(0, |code, digit| digit.map(|digit| code * 16 + digit));
        code.ok_or_else(|| self.error(at, "expected four hexadecimal digits"))
    }

    /// A number, `null`, `true` or `false`.
    fn word(&mut self, at: usize) -> Result<Json, String> {
        let is_of_word = |c: char| c.is_ascii_alphanumeric() || matches!(c, '+' | '-' | '.');
        while self.chars.next_if(|&(_, c)| is_of_word(c)).is_some() {}
        let end = self.chars.peek().map_or(self.text.len(), |&(end, _)| end);
        match &self.text[at..end] {
            "null" => Ok(Json::Null),
            "true" => Ok(Json::Bool(true)),
            "false" => Ok(Json::Bool(false)),
            word => number(word).map(Json::Number).ok_or_else(|| {
                let shown: String = self.text[at..].chars().take(30).collect();
                self.error(at, &format!("{shown:?} begins with no finite number or other value"))
            }),
        }
    }
}

/// A number in JSON's own grammar, which is narrower than Rust's.
fn number(word: &str) -> Option<f64> {
    let digits = |text: &str| text.bytes().take_while(u8::is_ascii_digit).count();
    let mut rest = word.strip_prefix('-').unwrap_or(word);
    let whole = digits(rest);
    if whole == 0 || (whole > 1 && rest.starts_with('0')) {
        return None;
    }
    rest = &rest[whole..];
    if let Some(after) = rest.strip_prefix('.') {
        let n = digits(after);
        rest = if n > 0 { &after[n..] } else { return None };
    }
    if let Some(after) = rest.strip_prefix(['e', 'E']) {
        let after = after.strip_prefix(['+', '-']).unwrap_or(after);
        let n = digits(after);
        rest = if n > 0 { &after[n..] } else { return None };
    }
    if rest.is_empty() { word.parse().ok().filter(|value: &f64| value.is_finite()) } else { None }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn every_kind_of_value_is_read() {
        let text =
            r#" {"a": [1, -0.0, 2.5e-3, 5e-324], "b": {"c": null, "d": true}, "é\u00e9\ud83d\ude00": "x\n\"" } "#;
        let numbers = [1.0, -0.0, 2.5e-3, 5e-324].map(Json::Number).to_vec();
        let inner = vec![("c".into(), Json::Null), ("d".into(), Json::Bool(true))];
        let expected = Json::Object(vec![
            ("a".into(), Json::List(numbers)),
            ("b".into(), Json::Object(inner)),
            ("éé😀".into(), Json::Text("x\n\"".into())),
        ]);
        assert_eq!(parse(text), Ok(expected));
        let Ok(Json::Number(zero)) = parse("-0.0") else { panic!("a number") };
        assert!(zero.is_sign_negative());
    }

    #[test]
    fn what_is_no_json_is_refused_with_its_line() {
        let deep = "[".repeat(100_000);
        let wrong = [
            "",
            "[1, 2",
            "[1 2]",
            "{\"a\" 1}",
            "{\"a\": 1, \"a\": 2}",
            "NaN",
            "1e999",
            "01",
            "1.",
            ".5",
            "+1",
            "0x10",
            "nul",
            "\"a",
            "\"\\x\"",
            "\"\\ud83d\"",
            "\"\\udc00\"",
            "[1],",
            "\"\u{1}\"",
            "{1: 2}",
            "[,]",
            "1e",
            &deep,
        ];
        for text in wrong {
            let refused = parse(text);
            assert!(refused.as_ref().is_err_and(|error| error.starts_with("line 1: ")), "{text:.20}: {refused:?}");
        }
        assert!(parse("[1,\n2,\n]").is_err_and(|error| error.starts_with("line 3: ")));
    }
}
