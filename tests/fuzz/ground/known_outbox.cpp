#include "tests/fuzz/ground/known_outbox.hpp"

#include <algorithm>

#include "fsw/base/crc.hpp"
#include "sim/ground/intake/outbox_reader.hpp"
#include "sim/host/files.hpp"
#include "tests/fuzz/special_values.hpp"
#include "tests/unit/ground/synthetic_flight.hpp"

namespace ilp::fuzz {
namespace {

using Bytes = std::vector<std::uint8_t>;

void mend_crc(Bytes& bytes) {
  if (bytes.size() < 4) return;
  const std::uint32_t crc = crc32(Octets(bytes).first(bytes.size() - 4));
  for (std::size_t i = 0; i < 4; ++i) bytes[bytes.size() - 4 + i] = static_cast<std::uint8_t>(crc >> (8 * i));
}

void put(Bytes& bytes, std::size_t at, std::uint64_t value, std::size_t octets) {
  for (std::size_t i = 0; i < octets && at + i < bytes.size(); ++i) {
    bytes[at + i] = static_cast<std::uint8_t>(value >> (8 * i));
  }
}

}  // namespace

const std::vector<KnownFile>& known_outbox() {
  static const std::vector<KnownFile> files = [] {
    const test::TemporaryFolder folder;
    // Small, so that the time of a trial goes into what is changed and not into pixels.
    test::SyntheticFlight flight = test::make_flight(false);
    flight.camera = {32, 24, 30, 30.25, 15.8, 11.8, 0, 0, 0, 0};
    flight.views.resize(3);
    flight.points.resize(12);
    test::write_outbox(flight, folder.path());
    std::vector<KnownFile> known;
    for (const auto& path : intake::files_of(folder.path())) {
      known.push_back({path.filename().string(), host::read_file(path)});
    }
    return known;
  }();
  return files;
}

void change(Choices& choices, KnownFile& file) {
  Bytes& bytes = file.bytes;
  const std::uint8_t how_many = choices.byte();
  for (unsigned i = 0; i < (how_many & 31U) && !choices.empty(); ++i) {
    const std::uint8_t how = choices.byte();
    // Near the beginning more often: heads and records before blobs and samples.
    const std::uint64_t place = choices.u16();
    const std::size_t at =
        bytes.empty() ? 0 : place % std::min<std::size_t>(bytes.size(), (how & 8U) != 0 ? 1024 : 65536);
    switch (how % 8) {
      case 0:
        put(bytes, at, choices.byte(), 1);
        break;
      case 1:
        put(bytes, at, special_value(choices.byte()), 8);
        break;
      case 2:
        put(bytes, at, special_value(choices.byte()), 4);
        break;
      case 3:
        put(bytes, at, choices.number(8), 8);
        break;
      case 4:
        if (at < bytes.size()) bytes[at] ^= static_cast<std::uint8_t>(1U << (choices.byte() & 7U));
        break;
      case 5:
        bytes.resize(at);
        break;
      case 6: {
        const Octets more = choices.bytes();
        bytes.insert(bytes.begin() + static_cast<std::ptrdiff_t>(at), more.begin(), more.end());
        break;
      }
      default:
        put(bytes, at, choices.u32(), 4);
        break;
    }
  }
  if ((how_many & 128U) == 0 && !file.name.ends_with(".jp2")) mend_crc(bytes);
}

}  // namespace ilp::fuzz
