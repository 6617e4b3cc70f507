#include "tests/distributed/spread_flight.hpp"

#include <gtest/gtest.h>
#include <unistd.h>

#include <chrono>
#include <csignal>
#include <cstdlib>
#include <cstring>
#include <sstream>
#include <thread>

#include "tests/distributed/stopped_program.hpp"
#include "tests/integration/flight_files.hpp"

namespace ilp::test {
namespace fs = std::filesystem;
namespace {

const fs::path& plain() {
  static const fs::path folder = prepared_flights() / "plain";
  return folder;
}

/// A database of its own on the server of with_postgres, as an address.
std::string new_database() {
  static int number = 0;
  const std::string name = "flight_" + std::to_string(::getpid()) + "_" + std::to_string(++number);
  write_file(fs::temp_directory_path() / name,
             "CREATE DATABASE " + name + " OWNER ilp TEMPLATE template0 ENCODING 'SQL_ASCII' LOCALE 'C';\n");
  const ProgramResult made = run_program({std::getenv("ILP_POSTGRES_SERVER"), "sql"}, fs::temp_directory_path() / name);
  fs::remove(fs::temp_directory_path() / name);
  EXPECT_EQ(made.exit_status, 0) << made.output;
  std::istringstream words(std::getenv("ILP_POSTGRES"));
  std::string host, port;
  for (std::string word; words >> word;) {
    if (word.rfind("host=", 0) == 0) host = word.substr(5);
    if (word.rfind("port=", 0) == 0) port = word.substr(5);
  }
  return "postgresql://ilp@/" + name + "?host=" + host + "&port=" + port;
}

}  // namespace

bool SpreadFlight::on_server() {
  return std::getenv("ILP_POSTGRES") != nullptr;
}

SpreadFlight::SpreadFlight(std::vector<std::string> split) : split_(std::move(split)), processes_(split_.size()) {
  store_ = on_server() && !split_[0].empty() ? new_database() : (folder() / "flight.db").string();
  fs::create_directories(folder() / "outbox");
  fs::create_directories(folder() / "acknowledged");
}

std::string SpreadFlight::database() const {
  const std::size_t begin = std::strlen("postgresql://ilp@/");
  return store_.substr(begin, store_.find('?') - begin);
}

ProgramResult SpreadFlight::sql(const std::string& statements) const {
  write_file(folder() / "statements.sql", statements);
  return run_program({std::getenv("ILP_POSTGRES_SERVER"), "sql", database()}, folder() / "statements.sql");
}

std::vector<std::string> SpreadFlight::primary_command(const std::string& name) const {
  std::vector<std::string> words = {ILP_ONBOARD,
                                    "--virtual-time",
                                    "--trap-heap",
                                    "--index",
                                    plain() / "index.txt",
                                    "--camera",
                                    camera_numbers(plain()),
                                    "--store",
                                    store_,
                                    "--state",
                                    folder() / ("state" + name),
                                    "--outbox",
                                    folder() / "outbox",
                                    "--acknowledgements",
                                    folder() / "acknowledged",
                                    "--lock-lease",
                                    std::to_string(lease_s_)};
  if (!split_[0].empty()) words.insert(words.end(), {"--stages", split_[0]});
  return words;
}

std::vector<std::string> SpreadFlight::node_command(const std::string& stages,
                                                    const std::vector<std::string>& more) const {
  std::vector<std::string> words = {
      ILP_ONBOARD, "--stages", stages, "--store", store_, "--lock-lease", std::to_string(lease_s_), "--trap-heap"};
  words.insert(words.end(), more.begin(), more.end());
  return words;
}

void SpreadFlight::start(std::size_t process) {
  const fs::path log = folder() / ("process-" + std::to_string(process) + ".txt");
  processes_[process] =
      std::make_unique<RunningProgram>(process == 0 ? primary_command() : node_command(split_[process]), log);
}

void SpreadFlight::start_all() {
  // In this order the nodes have to wait for the primary, and for the database.
  for (std::size_t k = split_.size(); k-- > 0;) start(k);
}

void SpreadFlight::kill(std::size_t process) {
  processes_[process]->send(SIGKILL);
  processes_[process]->wait();
}

void SpreadFlight::freeze(std::size_t process) {
  processes_[process]->send(SIGSTOP);
}

void SpreadFlight::thaw(std::size_t process) {
  processes_[process]->send(SIGCONT);
}

bool SpreadFlight::freeze_in_transaction(std::size_t process) {
  return stop_in_transaction(*processes_[process], store_, 20'000);
}

bool SpreadFlight::runs(std::size_t process) {
  return processes_[process]->runs();
}

bool SpreadFlight::keep_up() {
  for (std::size_t k = 0; k < split_.size(); ++k) {
    if (processes_[k]->runs()) continue;
    const int status = processes_[k]->wait();
    if (status == 0 && k == 0) return true;
    if (status != 0) start(k);
  }
  return false;
}

std::vector<int> SpreadFlight::wait() {
  std::vector<int> statuses;
  for (const auto& process : processes_) statuses.push_back(process->wait());
  return statuses;
}

std::string SpreadFlight::output(std::size_t process) const {
  return processes_[process]->output();
}

std::size_t SpreadFlight::files_sent() const {
  std::size_t files = 0;
  std::error_code error;
  for (const auto& entry : fs::directory_iterator(folder() / "outbox", error)) {
    if (entry.path().extension() != ".part") ++files;
  }
  return files;
}

std::string SpreadFlight::digest() const {
  const ProgramResult result = run_program({ILP_STORE, "digest", store_});
  EXPECT_EQ(result.exit_status, 0) << result.output;
  return result.output;
}

const std::string& digest_of_one_process() {
  static const std::string digest = [] {
    SpreadFlight flight({""});
    flight.start_all();
    EXPECT_EQ(flight.wait(), std::vector<int>{0}) << flight.output(0);
    return flight.digest();
  }();
  return digest;
}

}  // namespace ilp::test
