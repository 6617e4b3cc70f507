// Another program at the flight's database: a plain connection of SQLite in a process of its own.
#pragma once

#include <sys/types.h>

#include <filesystem>

namespace ilp::faults {

class Neighbour {
 public:
  /// Begins the process, which does nothing before it is asked. Call it in a process that has no database open.
  explicit Neighbour(const std::filesystem::path& database);
  ~Neighbour();
  Neighbour(const Neighbour&) = delete;
  Neighbour& operator=(const Neighbour&) = delete;

  /// Each answers when it is done; false if SQLite refuses.
  bool read() const { return ask('r'); }    ///< begins a transaction that reads
  bool lock() const { return ask('w'); }    ///< begins a transaction that writes, and writes nothing
  bool finish() const { return ask('e'); }  ///< ends the transaction
  void kill();

 private:
  [[nodiscard]] bool ask(char what) const;

  pid_t process_ = -1;
  int to_ = -1, from_ = -1;
};

}  // namespace ilp::faults
