// A flight of ilp-onboard in several processes over one store, on this machine.
#pragma once

#include <filesystem>
#include <memory>
#include <string>
#include <vector>

#include "tests/integration/flight_files.hpp"
#include "tests/integration/running_program.hpp"
#include "tests/unit/hal/temporary_folder.hpp"

namespace ilp::test {

/// The store lies in a database file, or on the server of with_postgres if the environment names one.
class SpreadFlight {
 public:
  /// `split[0]` are the primary's stages, as --stages takes them, or "" for all of them in one process.
  explicit SpreadFlight(std::vector<std::string> split);

  [[nodiscard]] static bool on_server();

  void start(std::size_t process);
  void start_all();
  /// SIGKILL.
  void kill(std::size_t process);
  /// SIGSTOP and SIGCONT.
  void freeze(std::size_t process);
  void thaw(std::size_t process);
  [[nodiscard]] bool runs(std::size_t process);
  /// SIGSTOP in the middle of a transaction; false when none is seen.
  bool freeze_in_transaction(std::size_t process);
  /// Starts every process again that has ended otherwise than in order. True when the primary has ended in order.
  bool keep_up();
  /// Waits until all have ended, and returns their exit statuses; -1 for one that does not end.
  std::vector<int> wait();
  [[nodiscard]] std::string output(std::size_t process) const;
  /// Whole files in the outbox: they tell how far the flight has come, on a machine of any speed.
  [[nodiscard]] std::size_t files_sent() const;

  /// Its name on the server.
  [[nodiscard]] std::string database() const;
  /// SQL as superuser in the flight's database on the server; the result has what it prints.
  [[nodiscard]] ProgramResult sql(const std::string& statements) const;

  /// The primary with other files beside the store: `name` tells them from its own.
  [[nodiscard]] std::vector<std::string> primary_command(const std::string& name = "") const;
  /// A process with these stages and further options, beside the flight.
  [[nodiscard]] std::vector<std::string> node_command(const std::string& stages,
                                                      const std::vector<std::string>& more = {}) const;
  /// What must be the same however the stages are spread: `ilp-store digest`.
  [[nodiscard]] std::string digest() const;
  /// For processes that are started from now on.
  void lease(int seconds) { lease_s_ = seconds; }
  [[nodiscard]] const std::string& store() const { return store_; }
  [[nodiscard]] const std::filesystem::path& folder() const { return folder_.path(); }

 private:
  TemporaryFolder folder_;
  int lease_s_ = 10;
  std::string store_;
  std::vector<std::string> split_;
  std::vector<std::unique_ptr<RunningProgram>> processes_;
};

/// The digest of the flight in one process over a database file.
[[nodiscard]] const std::string& digest_of_one_process();

}  // namespace ilp::test
