// The ground's catalogue: a database that is damaged anywhere ends in words for the user or is set aside.
#include <filesystem>
#include <stdexcept>

#include "sim/ground/intake/catalogue.hpp"
#include "sim/ground/intake/flight_model.hpp"
#include "sim/host/files.hpp"
#include "tests/fuzz/ground/known_outbox.hpp"
#include "tests/unit/ground/synthetic_flight.hpp"

namespace ilp::fuzz {
namespace {

namespace fs = std::filesystem;
using Bytes = std::vector<std::uint8_t>;

/// A catalogue that holds the known outbox, as a database file.
const KnownFile& known_catalogue() {
  static const KnownFile file = [] {
    const test::TemporaryFolder folder;
    const fs::path outbox = folder.path() / "outbox", path = folder.path() / "catalogue.db";
    fs::create_directories(outbox);
    for (const KnownFile& known : known_outbox()) host::write_file(outbox / known.name, known.bytes);
    {
      intake::Catalogue catalogue(path);
      static_cast<void>(catalogue.take_in(outbox));
    }
    return KnownFile{"catalogue.db", host::read_file(path)};
  }();
  return file;
}

}  // namespace

void ground_catalogue(Octets input) {
  Choices choices(input);
  const test::TemporaryFolder folder;
  const fs::path path = folder.path() / "catalogue.db", outbox = folder.path() / "outbox";
  KnownFile database = known_catalogue();
  // Any page, not only the first ones.
  for (int i = 0; i < 4 && !choices.empty() && !database.bytes.empty(); ++i) {
    const std::size_t at = choices.u32() % database.bytes.size();
    KnownFile part{"", {database.bytes.begin() + static_cast<std::ptrdiff_t>(at), database.bytes.end()}};
    part.name = ".jp2";
    change(choices, part);
    database.bytes.resize(at);
    database.bytes.insert(database.bytes.end(), part.bytes.begin(), part.bytes.end());
  }
  host::write_file(path, database.bytes);
  fs::create_directories(outbox);
  for (std::size_t i = 0; i < 2; ++i) {
    const KnownFile& known = known_outbox()[choices.byte() % known_outbox().size()];
    host::write_file(outbox / known.name, known.bytes);
  }
  // Not everything every time: most inputs are bad at the first look.
  const std::uint8_t what = choices.byte();
  try {
    intake::Catalogue catalogue(path);
    if ((what & 1U) == 0) static_cast<void>(catalogue.take_in(outbox));
    if ((what & 2U) == 0) {
      intake::Outbox held = catalogue.outbox();
      static_cast<void>(intake::index_flight(held));
    }
    if ((what & 4U) == 0) {
      static_cast<void>(catalogue.look(1, 1));
      catalogue.put_look(1, 1, Bytes(10));
    }
    if ((what & 8U) == 0) {
      static_cast<void>(catalogue.summary({1, {0, 0}}, 1));
      catalogue.put({1, {0, 0}}, 1, Bytes(10), Bytes(10));
    }
  } catch (const std::runtime_error&) {
  }
}

}  // namespace ilp::fuzz
