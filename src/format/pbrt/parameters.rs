//! Parameters of a directive: `"type name" values`, as the reader asks for them. What it has not asked for in the end is named in a
//! warning.

use super::tokens::{Token, Tokens};
use crate::error::SourceLocation;
use crate::{Error, Result};
use glam::DVec3;
use std::cell::{Cell, RefCell};
use std::collections::HashSet;
use std::rc::Rc;

/// Values of one kind.
#[derive(Clone, Debug)]
pub(super) enum Values {
    Numbers(Vec<f64>),
    Texts(Vec<String>),
    Flags(Vec<bool>),
}

/// One parameter.
#[derive(Debug)]
pub(super) struct Parameter {
    pub(crate) kind: String,
    pub(crate) name: String,
    pub(crate) values: Values,
    pub(crate) at: SourceLocation,
    used: Cell<bool>,
}

/// What a directive makes, with its parameters.
#[derive(Clone, Debug)]
pub(super) struct Parameters {
    /// As in `Material "diffuse"`.
    pub(crate) plugin: String,
    pub(crate) directive: &'static str,
    pub(crate) at: SourceLocation,
    list: Vec<Rc<Parameter>>,
    /// What `Attribute` says of all directives of this kind.
    common: Vec<Rc<Parameter>>,
}

/// What a user should know, each once.
#[derive(Default)]
pub(super) struct Warnings {
    list: RefCell<Vec<String>>,
    met: RefCell<HashSet<String>>,
}

impl Warnings {
    pub(crate) fn add(&self, at: &SourceLocation, message: impl std::fmt::Display) {
        let warning = format!("{}:{}: {message}", at.path.display(), at.line);
        if self.met.borrow_mut().insert(warning.clone()) {
            self.list.borrow_mut().push(warning);
        }
    }

    pub(crate) fn into_list(self) -> Vec<String> {
        self.list.into_inner()
    }
}

impl Parameters {
    /// A directive of which the text says nothing.
    pub(crate) fn none(directive: &'static str, plugin: &str, at: SourceLocation) -> Parameters {
        Parameters { plugin: plugin.to_string(), directive, at, list: Vec::new(), common: Vec::new() }
    }

    /// Reads all parameters up to the next word that is none.
    ///
    /// # Errors
    /// With file and line: values that are none, or of several kinds; a parameter without type or name.
    pub(crate) fn read(
        tokens: &mut Tokens,
        directive: &'static str,
        plugin: String,
        at: SourceLocation,
        common: Vec<Rc<Parameter>>,
    ) -> Result<Parameters> {
        let mut list = Vec::new();
        while tokens.peek()?.is_some_and(|token| token.quoted) {
            let declared = tokens.needed("a parameter")?;
            let place = tokens.place(&declared);
            let mut words = declared.text.split_whitespace();
            let (Some(kind), Some(name), None) = (words.next(), words.next(), words.next()) else {
                return Err(place.error(format!("`{}` is not a type and a name of a parameter", declared.text)));
            };
            let values = values(tokens, kind, name)?;
            let (kind, name) = (kind.to_string(), name.to_string());
            list.push(Rc::new(Parameter { kind, name, values, at: place, used: Cell::new(false) }));
        }
        Ok(Parameters { plugin, directive, at, list, common })
    }

    pub(crate) fn into_list(self) -> Vec<Rc<Parameter>> {
        self.list
    }

    pub(crate) fn label(&self) -> String {
        format!("{} \"{}\"", self.directive, self.plugin)
    }

    pub(crate) fn error(&self, message: impl Into<String>) -> Error {
        self.at.error(message)
    }

    /// The parameter of this name.
    pub(crate) fn find(&self, name: &str) -> Option<&Parameter> {
        let named = |parameter: &&Rc<Parameter>| parameter.name == name;
        let own = self.list.iter().rfind(named);
        // what stands for all may mean nothing to one
        let found = own.or_else(|| self.common.iter().rfind(named))?;
        found.used.set(true);
        Some(found)
    }

    /// The first of these names that is said.
    pub(crate) fn first_of<'n>(&self, names: &[&'n str]) -> Option<(&Parameter, &'n str)> {
        names.iter().find_map(|name| self.find(name).map(|found| (found, *name)))
    }

    fn mismatch<T>(&self, found: &Parameter, wanted: &str) -> Result<T> {
        Err(found.at.error(format!("`{}` of {} must be {wanted}", found.name, self.label())))
    }

    /// All numbers of a parameter.
    pub(crate) fn numbers(&self, name: &str) -> Result<Option<&[f64]>> {
        match self.find(name) {
            None => Ok(None),
            Some(Parameter { values: Values::Numbers(numbers), .. }) => Ok(Some(numbers)),
            Some(found) => self.mismatch(found, "numbers"),
        }
    }

    pub(crate) fn maybe_number(&self, name: &str) -> Result<Option<f64>> {
        match self.numbers(name)? {
            None => Ok(None),
            Some([number]) => Ok(Some(*number)),
            Some(_) => self.mismatch(self.find(name).expect("it was found"), "one number"),
        }
    }

    pub(crate) fn number(&self, name: &str, default: f64) -> Result<f64> {
        Ok(self.maybe_number(name)?.unwrap_or(default))
    }

    pub(crate) fn vector(&self, name: &str) -> Result<Option<DVec3>> {
        match self.numbers(name)? {
            None => Ok(None),
            Some(&[x, y, z]) => Ok(Some(DVec3::new(x, y, z))),
            Some(_) => self.mismatch(self.find(name).expect("it was found"), "three numbers"),
        }
    }

    /// Points or vectors, three numbers each.
    pub(crate) fn vectors(&self, name: &str) -> Result<Option<Vec<[f32; 3]>>> {
        self.groups(name)
    }

    /// Numbers in groups.
    pub(crate) fn groups<const N: usize>(&self, name: &str) -> Result<Option<Vec<[f32; N]>>> {
        let Some(numbers) = self.numbers(name)? else { return Ok(None) };
        let (groups, rest) = numbers.as_chunks::<N>();
        if !rest.is_empty() {
            return self.mismatch(self.find(name).expect("it was found"), &format!("groups of {N} numbers"));
        }
        Ok(Some(groups.iter().map(|group| group.map(|x| x as f32)).collect()))
    }

    pub(crate) fn text(&self, name: &str) -> Result<Option<&str>> {
        match self.find(name) {
            None => Ok(None),
            Some(Parameter { values: Values::Texts(texts), .. }) if texts.len() == 1 => Ok(Some(&texts[0])),
            Some(found) => self.mismatch(found, "one string"),
        }
    }

    pub(crate) fn flag(&self, name: &str, default: bool) -> Result<bool> {
        match self.find(name) {
            None => Ok(default),
            Some(Parameter { values: Values::Flags(flags), .. }) if flags.len() == 1 => Ok(flags[0]),
            // as version 3 writes them
            Some(Parameter { values: Values::Texts(texts), .. }) if *texts == ["true"] => Ok(true),
            Some(Parameter { values: Values::Texts(texts), .. }) if *texts == ["false"] => Ok(false),
            Some(found) => self.mismatch(found, "true or false"),
        }
    }

    /// Passes over what means nothing here, without a word.
    pub(crate) fn ignore(&self, names: &[&str]) {
        names.iter().for_each(|name| _ = self.find(name));
    }

    /// Warns of what has not been asked for.
    pub(crate) fn finish(&self, warnings: &Warnings) {
        for left in self.list.iter().filter(|parameter| !parameter.used.get()) {
            warnings.add(&left.at, format!("`{}` of {} means nothing here", left.name, self.label()));
        }
    }
}

/// One value, or several in brackets.
fn values(tokens: &mut Tokens, kind: &str, name: &str) -> Result<Values> {
    let what = format!("the value of `{name}`");
    let first = tokens.needed(&what)?;
    if first.quoted || first.text != "[" {
        let mut values = none(&first, kind);
        push(tokens, &mut values, &first, name)?;
        return Ok(values);
    }
    let mut found: Option<Values> = None;
    loop {
        let token = tokens.needed(&format!("`]` of `{name}`"))?;
        if !token.quoted && token.text == "]" {
            return Ok(found.unwrap_or(Values::Numbers(Vec::new())));
        }
        let values = found.get_or_insert_with(|| none(&token, kind));
        push(tokens, values, &token, name)?;
    }
}

/// No values yet, of the kind of this one.
fn none(token: &Token, kind: &str) -> Values {
    match (token.quoted, &*token.text) {
        (true, _) => Values::Texts(Vec::new()),
        (false, "true" | "false") if kind == "bool" => Values::Flags(Vec::new()),
        _ => Values::Numbers(Vec::new()),
    }
}

fn push(tokens: &Tokens, values: &mut Values, token: &Token, name: &str) -> Result<()> {
    let wrong = |wanted: &str| Err(tokens.place(token).error(format!("`{}` in `{name}` is not {wanted}", token.text)));
    match values {
        Values::Texts(texts) if token.quoted => texts.push(token.text.to_string()),
        Values::Texts(_) => return wrong("a string"),
        Values::Flags(flags) => match &*token.text {
            "true" if !token.quoted => flags.push(true),
            "false" if !token.quoted => flags.push(false),
            _ => return wrong("true or false"),
        },
        Values::Numbers(numbers) => match number(&token.text) {
            Some(number) if !token.quoted => numbers.push(number),
            _ => return wrong("a number"),
        },
    }
    Ok(())
}

/// A number that single precision can hold.
pub(super) fn number(text: &str) -> Option<f64> {
    let number: f64 = fast_float2::parse(text.strip_prefix('+').unwrap_or(text)).ok()?;
    (number as f32).is_finite().then_some(number)
}
