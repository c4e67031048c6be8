//! The columns of a channel's table, by the schema of its messages.
//!
//! A nested message becomes columns of its own, like `percept.p`. A schema may nest itself, or fan out so
//! that its columns grow exponentially with its depth, so there are bounds: a message that lies in its own
//! kind, deeper than [`MAX_DEPTH`], or whose fields would make more than [`MAX_COLUMNS`] columns, is one
//! column that holds JSON. Messages nearer to the root get their columns first. Memory and time are linear in
//! the schema and in [`MAX_COLUMNS`] times [`MAX_DEPTH`].

use std::collections::VecDeque;

use prost_reflect::{DynamicMessage, FieldDescriptor, Kind, MessageDescriptor, Value};

use super::cell;

/// Levels of nested messages that become columns; Barrelman's own messages have four.
pub const MAX_DEPTH: usize = 8;
/// Columns of a table.
pub const MAX_COLUMNS: usize = 1_000;
/// Bytes of the names of all columns of a table. A nested field's name holds those of the messages around it.
pub const MAX_NAME_BYTES: usize = 256 << 10;

/// The name of the only column where the message itself has more fields than there may be columns.
const WHOLE_MESSAGE: &str = "message";

/// The columns of a kind of message.
pub(super) struct Columns {
    /// The root comes first.
    nodes: Vec<Node>,
}

struct Node {
    /// The field in the message around it; the root has none.
    field: Option<FieldDescriptor>,
    /// The field's name, behind those of the messages around it.
    name: String,
    /// The kind, where it is a message by itself: not one in a list or a map.
    message: Option<MessageDescriptor>,
    parent: Option<usize>,
    /// How many messages lie around it.
    depth: usize,
    /// The nodes of its fields, where these are columns.
    fields: Option<Vec<usize>>,
}

impl Columns {
    /// The columns of a message.
    pub(super) fn new(root: MessageDescriptor) -> Self {
        let root = Node {
            field: None,
            name: String::new(),
            message: Some(root),
            parent: None,
            depth: 0,
            fields: None,
        };
        let mut columns = Self { nodes: vec![root] };
        let (mut count, mut name_bytes) = (1, 0);
        let mut waiting = VecDeque::from([0]);
        while let Some(index) = waiting.pop_front() {
            let node = &columns.nodes[index];
            let Some(message) = node.message.clone() else { continue };
            if node.depth >= MAX_DEPTH || columns.lies_in(node.parent, &message) {
                continue;
            }
            let more = message.fields().len();
            if count - 1 + more > MAX_COLUMNS {
                continue;
            }
            let prefix = if index == 0 { String::new() } else { format!("{}.", node.name) };
            let more_bytes: usize = message.fields().map(|field| prefix.len() + field.name().len()).sum();
            if name_bytes - node.name.len() + more_bytes > MAX_NAME_BYTES {
                continue;
            }
            count = count - 1 + more;
            name_bytes = name_bytes - node.name.len() + more_bytes;
            let depth = node.depth + 1;
            let first = columns.nodes.len();
            columns.nodes.extend(message.fields().map(|field| Node {
                name: format!("{prefix}{}", field.name()),
                message: match field.kind() {
                    Kind::Message(nested) if !field.is_list() && !field.is_map() => Some(nested),
                    _ => None,
                },
                field: Some(field),
                parent: Some(index),
                depth,
                fields: None,
            }));
            waiting.extend(first..columns.nodes.len());
            columns.nodes[index].fields = Some((first..columns.nodes.len()).collect());
        }
        if columns.nodes[0].fields.is_none() {
            WHOLE_MESSAGE.clone_into(&mut columns.nodes[0].name);
        }
        columns
    }

    /// Their names, in the order of the schema.
    pub(super) fn names(&self) -> Vec<String> {
        let mut names = Vec::new();
        self.visit(0, &mut |node| names.push(node.name.clone()));
        names
    }

    /// The names of those that hold JSON.
    pub(super) fn json(&self) -> Vec<String> {
        let mut names = Vec::new();
        self.visit(0, &mut |node| names.extend(node.message.as_ref().map(|_| node.name.clone())));
        names
    }

    /// The cells of a message.
    pub(super) fn cells(&self, content: &DynamicMessage) -> Vec<String> {
        let mut cells = Vec::new();
        match self.nodes[0].fields {
            Some(_) => self.add_cells(0, Some(content), &mut cells),
            None => cells.push(cell::json(content)),
        }
        cells
    }

    fn add_cells(&self, index: usize, content: Option<&DynamicMessage>, cells: &mut Vec<String>) {
        for index in self.nodes[index].fields.iter().flatten() {
            let node = &self.nodes[*index];
            let Some(field) = &node.field else { continue };
            let present = content.filter(|content| !field.supports_presence() || content.has_field(field));
            let value = present.map(|content| content.get_field(field));
            if node.fields.is_some() {
                self.add_cells(*index, value.as_deref().and_then(Value::as_message), cells);
            } else {
                cells.push(value.map(|value| cell::render_cell(field, &value)).unwrap_or_default());
            }
        }
    }

    /// Visits those that are columns.
    fn visit(&self, index: usize, column: &mut impl FnMut(&Node)) {
        match &self.nodes[index].fields {
            Some(fields) => fields.iter().for_each(|field| self.visit(*field, column)),
            None => column(&self.nodes[index]),
        }
    }

    /// Whether a node or one around it is of this kind.
    fn lies_in(&self, mut node: Option<usize>, kind: &MessageDescriptor) -> bool {
        while let Some(index) = node {
            if self.nodes[index].message.as_ref() == Some(kind) {
                return true;
            }
            node = self.nodes[index].parent;
        }
        false
    }
}
