//! The language server protocol over standard input and output.
//!
//! Requests are answered at once, from the text as it is. What `phisindy check` says takes as long as its data
//! files are, so a thread of its own looks at the newest text of each file.

use crate::complete::complete;
use crate::descriptions::Known;
use crate::diagnose::{known, mistakes};
use crate::document::Document;
use crate::hover::hover;
use crate::position::{Lines, byte, range};
use lsp_server::{Connection, ErrorCode, Message, Notification, Request, RequestId, Response};
use lsp_types::notification::{
    DidChangeTextDocument, DidCloseTextDocument, DidOpenTextDocument, DidSaveTextDocument, Notification as _,
    PublishDiagnostics,
};
use lsp_types::request::{Completion, DocumentSymbolRequest, Formatting, HoverRequest, Request as _};
use lsp_types::{
    CompletionItem, CompletionOptions, CompletionParams, CompletionTextEdit, DidChangeTextDocumentParams,
    DidCloseTextDocumentParams, DidOpenTextDocumentParams, DidSaveTextDocumentParams,
    DocumentFormattingParams, DocumentSymbol, DocumentSymbolParams, Documentation, Hover, HoverContents,
    HoverParams, HoverProviderCapability, MarkupContent, MarkupKind, OneOf, PublishDiagnosticsParams,
    ServerCapabilities, SymbolKind, TextDocumentSyncCapability, TextDocumentSyncKind,
    TextDocumentSyncOptions, TextEdit, Uri,
};
use phisindy::files::Request as Asked;
use phisindy_expr::Span;
use phisindy_phys::outline::{Entry, Node};
use phisindy_phys::{SourceId, format};
use serde::de::DeserializeOwned;
use serde_json::{Value, json};
use std::collections::HashMap;
use std::path::PathBuf;
use std::sync::mpsc::{self, Receiver};

/// Serves an editor until it says that it ends. `asked` says where data files and laws are.
///
/// # Errors
/// The other side breaks the protocol, or a stream is closed too early.
pub fn serve(asked: &Asked) -> Result<(), String> {
    let (connection, threads) = Connection::stdio();
    talk(connection, asked).map_err(|error| error.to_string())?;
    threads.join().map_err(|error| error.to_string())
}

fn talk(connection: Connection, asked: &Asked) -> Result<(), lsp_server::ProtocolError> {
    let sync = TextDocumentSyncOptions {
        open_close: Some(true),
        change: Some(TextDocumentSyncKind::FULL),
        save: Some(true.into()),
        ..TextDocumentSyncOptions::default()
    };
    let completion = CompletionOptions {
        trigger_characters: Some(["\"", "(", "{", "[", ",", "*", "/"].map(str::to_owned).to_vec()),
        ..CompletionOptions::default()
    };
    let able = ServerCapabilities {
        text_document_sync: Some(TextDocumentSyncCapability::Options(sync)),
        hover_provider: Some(HoverProviderCapability::Simple(true)),
        completion_provider: Some(completion),
        document_formatting_provider: Some(OneOf::Left(true)),
        document_symbol_provider: Some(OneOf::Left(true)),
        ..ServerCapabilities::default()
    };
    let (id, _) = connection.initialize_start()?;
    let server = json!({ "name": "phisindy", "version": env!("CARGO_PKG_VERSION") });
    connection.initialize_finish(id, json!({ "capabilities": able, "serverInfo": server }))?;
    std::thread::scope(|scope| {
        let (checks, jobs) = mpsc::channel();
        let sender = connection.sender.clone();
        scope.spawn(move || check(&jobs, asked, &|message| drop(sender.send(message))));
        let mut files = Files { texts: HashMap::new(), checks, asked };
        for message in &connection.receiver {
            match message {
                Message::Request(request) if connection.handle_shutdown(&request)? => break,
                Message::Request(request) => {
                    // A closed stream ends the loop.
                    let _ = connection.sender.send(files.answer(request).into());
                }
                Message::Notification(note) => files.note(note),
                Message::Response(_) => {}
            }
        }
        Ok(())
    })
}

/// A text to check; none: its file was closed, and its mistakes go.
type Job = (Uri, Option<String>);

/// Publishes the mistakes of texts; those that were changed meanwhile are passed over.
fn check(jobs: &Receiver<Job>, asked: &Asked, send: &dyn Fn(Message)) {
    while let Ok(first) = jobs.recv() {
        let mut newest: Vec<Job> = Vec::new();
        for job in std::iter::once(first).chain(jobs.try_iter()) {
            newest.retain(|(uri, _)| *uri != job.0);
            newest.push(job);
        }
        for (uri, text) in newest {
            let diagnostics = text.map(|text| mistakes(&uri, &path(&uri), &text, asked)).unwrap_or_default();
            let params = PublishDiagnosticsParams { uri, diagnostics, version: None };
            send(Notification::new(PublishDiagnostics::METHOD.to_owned(), params).into());
        }
    }
}

/// The path of a file; of a text without one a name in the working folder.
fn path(uri: &Uri) -> PathBuf {
    let text = uri.as_str();
    let named = text.strip_prefix("file://").and_then(|rest| rest.find('/').map(|at| &rest[at..]));
    let mut bytes = Vec::new();
    let mut rest = named.unwrap_or("untitled.ron").as_bytes();
    while let [first, after @ ..] = rest {
        let code = after.get(..2).filter(|_| *first == b'%').and_then(|two| std::str::from_utf8(two).ok());
        let byte = code.and_then(|two| u8::from_str_radix(two, 16).ok());
        bytes.push(byte.unwrap_or(*first));
        rest = if byte.is_some() { &after[2..] } else { after };
    }
    let path = String::from_utf8_lossy(&bytes).into_owned();
    // `/C:/rig.ron`
    let drive = path.as_bytes().get(2) == Some(&b':');
    PathBuf::from(if drive { &path[1..] } else { &path })
}

/// The open files.
struct Files<'a> {
    texts: HashMap<String, (String, Known)>,
    checks: mpsc::Sender<Job>,
    asked: &'a Asked,
}

impl Files<'_> {
    /// A note that cannot be read is passed over.
    fn note(&mut self, note: Notification) {
        match note.method.as_str() {
            DidOpenTextDocument::METHOD => {
                if let Some(DidOpenTextDocumentParams { text_document: file }) = read(note) {
                    self.take(file.uri, file.text);
                }
            }
            DidChangeTextDocument::METHOD => {
                if let Some(DidChangeTextDocumentParams { text_document: file, mut content_changes }) =
                    read(note)
                    && let Some(change) = content_changes.pop()
                {
                    self.take(file.uri, change.text);
                }
            }
            // Data files may have changed as well.
            DidSaveTextDocument::METHOD => {
                if let Some(DidSaveTextDocumentParams { text_document: file, .. }) = read(note)
                    && let Some((text, _)) = self.texts.get(file.uri.as_str())
                {
                    let _ = self.checks.send((file.uri, Some(text.clone())));
                }
            }
            DidCloseTextDocument::METHOD => {
                if let Some(DidCloseTextDocumentParams { text_document: file }) = read(note) {
                    self.texts.remove(file.uri.as_str());
                    let _ = self.checks.send((file.uri, None));
                }
            }
            _ => {}
        }
    }

    fn take(&mut self, uri: Uri, text: String) {
        let before = self.texts.remove(uri.as_str()).map(|(_, known)| known).unwrap_or_default();
        let known = known(&path(&uri), &text, self.asked, before);
        self.texts.insert(uri.as_str().to_owned(), (text.clone(), known));
        let _ = self.checks.send((uri, Some(text)));
    }

    fn answer(&self, request: Request) -> Response {
        let Request { id, method, params } = request;
        match method.as_str() {
            Completion::METHOD => self.about(
                id,
                params,
                |p: &CompletionParams| &p.text_document_position.text_document.uri,
                completion,
            ),
            HoverRequest::METHOD => self.about(
                id,
                params,
                |p: &HoverParams| &p.text_document_position_params.text_document.uri,
                hovered,
            ),
            Formatting::METHOD => self.about(
                id,
                params,
                |p: &DocumentFormattingParams| &p.text_document.uri,
                |document, _, _| formatted(document),
            ),
            DocumentSymbolRequest::METHOD => self.about(
                id,
                params,
                |p: &DocumentSymbolParams| &p.text_document.uri,
                |document, _, _| symbols(document),
            ),
            _ => Response::new_err(
                id,
                ErrorCode::MethodNotFound as i32,
                format!("`{method}` is not known here"),
            ),
        }
    }

    /// Answers a request about a file; a file that is not open has no answer.
    fn about<P: DeserializeOwned>(
        &self,
        id: RequestId,
        params: Value,
        uri: impl Fn(&P) -> &Uri,
        answer: impl Fn(&Document<'_>, &Known, &P) -> Value,
    ) -> Response {
        match serde_json::from_value::<P>(params) {
            Ok(params) => {
                let uri = uri(&params);
                let of = |(text, known): &(String, Known)| {
                    answer(&Document::new(text, &path(uri)), known, &params)
                };
                Response::new_ok(id, self.texts.get(uri.as_str()).map_or(Value::Null, of))
            }
            Err(error) => Response::new_err(id, ErrorCode::InvalidParams as i32, error.to_string()),
        }
    }
}

fn read<P: DeserializeOwned>(note: Notification) -> Option<P> {
    serde_json::from_value(note.params).ok()
}

fn markdown(value: String) -> MarkupContent {
    MarkupContent { kind: MarkupKind::Markdown, value }
}

fn completion(document: &Document<'_>, known: &Known, params: &CompletionParams) -> Value {
    let (all, span) = complete(document, known, byte(document.text, params.text_document_position.position));
    let range = range(document.text, span);
    let item = |(k, c): (usize, crate::Completion)| CompletionItem {
        kind: Some(c.of),
        detail: Some(c.detail),
        documentation: c.about.map(|about| Documentation::MarkupContent(markdown(about))),
        // In the order of the table.
        sort_text: Some(format!("{k:04}")),
        filter_text: Some(c.insert.trim_end_matches([':', ' ', '(']).to_owned()),
        text_edit: Some(CompletionTextEdit::Edit(TextEdit::new(range, c.insert))),
        label: c.label,
        ..CompletionItem::default()
    };
    json!(all.into_iter().enumerate().map(item).collect::<Vec<_>>())
}

fn hovered(document: &Document<'_>, known: &Known, params: &HoverParams) -> Value {
    let said = hover(document, known, byte(document.text, params.text_document_position_params.position));
    let hover = |(about, span): (String, Span)| Hover {
        contents: HoverContents::Markup(markdown(about)),
        range: Some(range(document.text, span)),
    };
    json!(said.map(hover))
}

/// One edit of the whole text; none where nothing is to do, or where it is no RON.
fn formatted(document: &Document<'_>) -> Value {
    let text = document.text;
    match format(text, SourceId(0)) {
        Ok(new) if new != text => json!([TextEdit::new(range(text, Span::new(0, text.len())), new)]),
        Ok(_) => json!([]),
        Err(_) => Value::Null,
    }
}

/// The fields of the whole, and the keys of their maps.
fn symbols(document: &Document<'_>) -> Value {
    json!(symbols_in(document, &Lines::new(document.text), &document.root, 1))
}

fn symbols_in(document: &Document<'_>, lines: &Lines<'_>, node: &Node, below: usize) -> Vec<DocumentSymbol> {
    let symbol = |entry: &Entry| {
        let key = entry.key.as_ref()?;
        let name = document.text[document.content(key).range()].to_owned();
        let children = (below > 0).then(|| symbols_in(document, lines, &entry.value, below - 1));
        #[expect(deprecated, reason = "the type has no other way to be made")]
        let symbol = DocumentSymbol {
            name: if name.is_empty() { "?".to_owned() } else { name },
            detail: None,
            kind: if below > 0 { SymbolKind::FIELD } else { SymbolKind::VARIABLE },
            tags: None,
            deprecated: None,
            range: lines.range(key.span.to(entry.value.span)),
            selection_range: lines.range(key.span),
            children: children.filter(|inner| !inner.is_empty()),
        };
        Some(symbol)
    };
    node.entries.iter().filter_map(symbol).collect()
}
