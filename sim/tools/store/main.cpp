// ilp-store: tools for the store of a flight in a file or on a server.
#include <CLI/CLI.hpp>
#include <iostream>
#include <vector>

#include "bsp/flight/stage_set.hpp"
#include "sim/host/command_line.hpp"
#include "sim/host/digest.hpp"
#include "sim/host/version_line.hpp"
#include "sim/tools/store/keyframe_digest.hpp"
#include "sim/tools/store/named_store.hpp"
#include "sim/tools/store/role_grants.hpp"
#include "sim/tools/store/store_digest.hpp"
#include "sim/tools/store/table_rows.hpp"

namespace {

using namespace ilp;
using namespace ilp::store_tool;

/// Ends with 1 where something is damaged.
int print_digest(const std::string& name, bool keyframes) {
  NamedStore named = NamedStore::for_reading(name);
  if (keyframes) {
    for (const std::string& line : keyframe_lines(named.store())) std::cout << line << '\n';
  }
  bool valid = true;
  for (const TableDigest& table : digest_of(named.store())) {
    std::cout << table.table << ' ' << table.rows << ' ' << host::digest_text(table.digest);
    if (table.damaged != 0) std::cout << " damaged " << table.damaged;
    std::cout << '\n';
    valid = valid && table.damaged == 0;
  }
  return valid ? 0 : 1;
}

/// Ends with 1 where something is damaged.
int print_table(const std::string& name, const std::string& table, const std::vector<std::string>& fields) {
  NamedStore named = NamedStore::for_reading(name);
  const std::int64_t damaged = print_rows(named.store(), table, fields, std::cout);
  if (damaged != 0) std::cerr << "ilp-store: " << damaged << " damaged records are left out\n";
  return damaged == 0 ? 0 : 1;
}

void create(const std::string& name) {
  bool made = false;
  static_cast<void>(NamedStore::with_tables(name, made));
  std::cout << (made ? "The tables were made.\n" : "The tables were there already.\n");
}

struct Process {
  std::string role;
  StageMask stages = 0;
};

Process process_of(const std::string& text) {
  const std::size_t at = text.find('=');
  if (at == std::string::npos) throw std::runtime_error(text + ": write ROLE=STAGE,STAGE...");
  Process process{text.substr(0, at), 0};
  StageNames culprit;
  if (!parse_stages(text.substr(at + 1).c_str(), process.stages, culprit)) {
    throw std::runtime_error(
        text + ": \"" + culprit.c_str() +
        "\" is no stage that a process can run: docs/schedule.md lists them, and `head` stands for "
        "all that need the camera or a link");
  }
  return process;
}

void print_roles(const std::vector<std::string>& texts) {
  std::vector<Process> processes;
  processes.reserve(texts.size());
  for (const std::string& text : texts) processes.push_back(process_of(text));
  StageMask taken = 0;
  for (const Process& process : processes) {
    if ((taken & process.stages) != 0) {
      throw std::runtime_error(std::string("a stage runs in one process only: ") +
                               stage_names(taken & process.stages).c_str());
    }
    taken |= process.stages;
  }
  std::cout
      << "-- Roles of a flight, one for each process. Carry this out as the owner of the tables, who may make roles.\n";
  std::cout << "-- Set passwords by \\password ROLE, which sends no readable one.\n";
  std::cout << "BEGIN;\n";
  for (const Process& process : processes) std::cout << role_sql(process.role, process.stages);
  std::cout << "COMMIT;\n";
}

}  // namespace

int main(int argc, char** argv) {
  try {
    host::CommandLine app("ilp-store", "Tools for the store of a flight: a database file, or postgresql://...",
                          "ilp-store digest flight/flight.db");
    app.require_subcommand(1);
    std::string name;
    bool keyframes = false;
    std::vector<std::string> processes;
    CLI::App* const digest = &host::add_subcommand(
        app, "digest", "prints for each table its rows and a checksum that is the same however the stages are spread",
        "ilp-store digest flight/flight.db",
        "Exit status: 0 done, 1 a record is damaged or cannot be read, 2 wrong call");
    digest->add_option("store", name, "file or postgresql://...")->required();
    digest->add_flag("--keyframes", keyframes, "before them, a line per keyframe with the checksums of its results");
    std::string table;
    std::vector<std::string> fields;
    CLI::App* const rows = &host::add_subcommand(
        app, "rows",
        "prints the records of a table, with tabs between the values; a flight may work with the store meanwhile",
        "ilp-store rows flight/flight.db pose",
        "Exit status: 0 done, 1 a record is damaged or cannot be read, 2 wrong call");
    rows->add_option("store", name, "file or postgresql://...")->required();
    rows->add_option("table", table, "one of docs/records.md, such as pose")->required();
    rows->add_option("field", fields, "the fields to print (default: all)");
    CLI::App* const tables = &host::add_subcommand(app, "create", "creates the tables if the database has none",
                                                   "ilp-store create postgresql://flight@server/flight");
    tables->add_option("store", name, "file or postgresql://...")->required();
    CLI::App* const roles = &host::add_subcommand(app, "roles", "prints SQL for the roles of a flight's processes",
                                                  "ilp-store roles camera=head vision=pose");
    roles->add_option("process", processes, "ROLE=STAGE,STAGE...; `head` stands for all that need the camera or a link")
        ->required();
    app.set_version_flag("--version", ilp::host::version_line("ilp-store"));
    if (const auto end = ilp::host::read_command_line(app, argc, argv)) return *end;
    if (digest->parsed()) return print_digest(name, keyframes);
    if (rows->parsed()) return print_table(name, table, fields);
    if (tables->parsed()) create(name);
    if (roles->parsed()) print_roles(processes);
  } catch (const std::exception& error) {
    std::cerr << "ilp-store: " << error.what() << '\n';
    return 1;
  }
  return 0;
}
