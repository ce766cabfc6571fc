// Starts `phisindy lsp` and connects it to the editor.
const { workspace } = require("vscode");
const { LanguageClient } = require("vscode-languageclient/node");

let client;

exports.activate = () => {
  const settings = workspace.getConfiguration("phisindy");
  const data = settings.get("data");
  const server = { command: settings.get("path"), args: ["lsp", ...(data ? ["--data", data] : [])] };
  const documents = { documentSelector: [{ language: "phisindy" }] };
  client = new LanguageClient("phisindy", "phisindy", server, documents);
  return client.start();
};

exports.deactivate = () => client?.stop();
