#include "bsp/flight/lock_lease.hpp"

#include <sys/stat.h>
#include <unistd.h>

#include <csignal>
#include <ctime>

#include "fsw/base/text.hpp"

namespace ilp {
namespace {

void end_process(int) {
  constexpr char why[] = "ilp-onboard: a transaction was not over within the lease of the lock: start again\n";
  static_cast<void>(::write(STDERR_FILENO, why, sizeof(why) - 1) > 0);
  ::_exit(3);
}

bool runs_this_program(int process) {
  FixedText<64> path;
  path.add("/proc/").add(std::int64_t{process}).add("/exe");
  struct stat own {
  }, other{};
  return ::stat("/proc/self/exe", &own) == 0 && ::stat(path.c_str(), &other) == 0 && own.st_dev == other.st_dev &&
         own.st_ino == other.st_ino;
}

}  // namespace

LeasedStore::LeasedStore(Store& inner, int lease_s) : ForwardingStore(inner), lease_s_(static_cast<unsigned>(lease_s)) {
  static_cast<void>(std::signal(SIGALRM, end_process));
}

Status LeasedStore::begin() {
  ::alarm(lease_s_);
  const Status begun = inner_.begin();
  if (!begun.ok()) ::alarm(0);
  return begun;
}

Status LeasedStore::commit() {
  const Status committed = inner_.commit();
  ::alarm(0);
  return committed;
}

void LeasedStore::rollback() {
  inner_.rollback();
  ::alarm(0);
}

bool wait_for_lock(SqliteStore* database) {
  if (database == nullptr) return false;
  Transaction transaction(*database);
  if (!transaction.begin().is(StatusCode::store_locked)) return false;
  constexpr timespec nap{0, 20'000'000};
  ::nanosleep(&nap, nullptr);
  return true;
}

Status LockWatch::look(SqliteStore& store, int lease_s) {
  const std::int64_t now_ms = sqlite::locked_ms(store.session());
  const int holder = now_ms > 0 ? sqlite::lock_holder(store.session()) : 0;
  if (holder != holder_) {
    holder_ = holder;
    since_ms_ = now_ms;
    reported_ = false;
  }
  if (holder == 0 || reported_ || now_ms - since_ms_ < std::int64_t{1000} * lease_s) return {};
  reported_ = true;
  const bool ours = holder > 0 && holder != ::getpid() && runs_this_program(holder);
  const bool ended = ours && ::kill(holder, SIGKILL) == 0;
  return {StatusCode::lock_holder, holder, ended ? 1 : 0};
}

}  // namespace ilp
