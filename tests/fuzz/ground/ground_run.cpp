// The ground's whole work, from a folder to the report: hostile files end in results or in words for the user.
#include "sim/ground/ground_run.hpp"

#include <filesystem>
#include <sstream>
#include <stdexcept>

#include "sim/host/files.hpp"
#include "tests/fuzz/ground/known_outbox.hpp"
#include "tests/unit/ground/synthetic_flight.hpp"

namespace ilp::fuzz {

namespace fs = std::filesystem;

void ground_run(Octets input) {
  Choices choices(input);
  const test::TemporaryFolder folder;
  ground::GroundOptions options{.outbox = folder.path() / "outbox", .out = folder.path() / "out"};
  fs::create_directories(options.outbox);
  for (const KnownFile& known : known_outbox()) {
    KnownFile file = known;
    change(choices, file);
    host::write_file(options.outbox / file.name, file.bytes);
  }
  std::ostringstream messages;
  try {
    static_cast<void>(ground::run_ground(options, messages));
  } catch (const std::runtime_error&) {
  }
}

}  // namespace ilp::fuzz
