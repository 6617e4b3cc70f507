#include "tests/faults/neighbour.hpp"

#include <sqlite3.h>
#include <sys/prctl.h>
#include <sys/wait.h>
#include <unistd.h>

#include <csignal>
#include <iostream>
#include <stdexcept>

namespace ilp::faults {
namespace {

constexpr int patience_ms = 1000;

bool run(sqlite3* db, const char* sql) {
  return sqlite3_exec(db, sql, nullptr, nullptr, nullptr) == SQLITE_OK;
}

[[noreturn]] void serve(const std::filesystem::path& database, int in, int out) {
  sqlite3* db = nullptr;
  char what = 0;
  while (::read(in, &what, 1) == 1) {
    bool done = db != nullptr || sqlite3_open_v2(database.c_str(), &db, SQLITE_OPEN_READWRITE, "unix") == SQLITE_OK;
    sqlite3_busy_timeout(db, patience_ms);
    // Nothing of the log is copied by it, and at its end nothing is tidied up.
    if (what == 'r') done = done && run(db, "BEGIN") && run(db, "SELECT count(*) FROM sqlite_schema");
    if (what == 'w') done = done && run(db, "BEGIN IMMEDIATE");
    if (what == 'e') done = done && run(db, "ROLLBACK");
    const char answer = done ? 'y' : 'n';
    if (::write(out, &answer, 1) != 1) break;
  }
  _exit(0);
}

}  // namespace

Neighbour::Neighbour(const std::filesystem::path& database) {
  int there[2], back[2];
  if (pipe(there) != 0 || pipe(back) != 0) throw std::runtime_error("no pipe");
  std::cout.flush();
  process_ = fork();
  if (process_ < 0) throw std::runtime_error("no process");
  if (process_ == 0) {
    prctl(PR_SET_PDEATHSIG, SIGKILL);
    ::close(there[1]);
    ::close(back[0]);
    serve(database, there[0], back[1]);
  }
  ::close(there[0]);
  ::close(back[1]);
  to_ = there[1];
  from_ = back[0];
}

Neighbour::~Neighbour() {
  kill();
  ::close(to_);
  ::close(from_);
}

bool Neighbour::ask(char what) const {
  char answer = 0;
  return ::write(to_, &what, 1) == 1 && ::read(from_, &answer, 1) == 1 && answer == 'y';
}

void Neighbour::kill() {
  if (process_ < 0) return;
  ::kill(process_, SIGKILL);
  waitpid(process_, nullptr, 0);
  process_ = -1;
}

}  // namespace ilp::faults
