// Lets system calls on files fail on command, whichever library of the program makes them. A program that links
// failing_calls.cpp uses these calls in place of the C library's.
#pragma once

#include <functional>
#include <string>

namespace ilp::test {

enum class Call : unsigned {
  read = 1,
  write = 2,
  synchronise = 4,
  truncate = 8,
  create = 16,
  remove = 32,
  rename = 64
};
constexpr unsigned operator|(Call a, Call b) {
  return static_cast<unsigned>(a) | static_cast<unsigned>(b);
}
constexpr unsigned operator|(unsigned a, Call b) {
  return a | static_cast<unsigned>(b);
}
/// The calls that change a disk.
inline constexpr unsigned changes =
    Call::write | Call::synchronise | Call::truncate | Call::create | Call::remove | Call::rename;

struct CallFault {
  unsigned calls = 0;    ///< kinds of call that are counted and fail: Call values combined with |
  int first = 1;         ///< number of the first call that fails, from 1
  int count = 1 << 30;   ///< number of consecutive calls that fail
  int reason = 5;        ///< errno of a failed call; 5 is EIO. With ENOSPC only writes that make a file grow fail
  bool ends = false;     ///< the process ends in the call, as if it were killed, instead of failing
  bool nothing = false;  ///< the call reads 0 octets instead of failing
  bool in_part = false;  ///< the last call before `first` reads or writes only half of its octets
};

/// While an object exists, calls on files whose path contains `part` are counted and fail as `fault` says. Only one
/// object may exist at a time.
class FailingCalls {
 public:
  FailingCalls(const std::string& part, const CallFault& fault);
  ~FailingCalls();
  FailingCalls(const FailingCalls&) = delete;
  FailingCalls& operator=(const FailingCalls&) = delete;

  /// Number of calls until now, with those that did not fail.
  [[nodiscard]] int seen() const;
  /// Whether a call has failed.
  [[nodiscard]] bool failed() const;
};

/// Runs `work` in a child process, which ends as in a power cut: in call number `call` of those that change a file
/// whose path contains `part`. Returns false if `work` was done before that call. A child that crashes aborts the
/// program.
[[nodiscard]] bool cut_in_call(const std::string& part, int call, const std::function<void()>& work);

}  // namespace ilp::test
