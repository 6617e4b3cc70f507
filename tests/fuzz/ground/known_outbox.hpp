// The outbox of a small flight, in memory: what inputs change is valid otherwise, so that it is looked at.
#pragma once

#include <string>
#include <vector>

#include "tests/fuzz/targets.hpp"

namespace ilp::fuzz {

struct KnownFile {
  std::string name;
  std::vector<std::uint8_t> bytes;
};

/// Records with their blobs, products, events; made once.
[[nodiscard]] const std::vector<KnownFile>& known_outbox();

/// Up to 32 changes of octets and lengths, as the input chooses; checksums are mended where it says so.
void change(Choices& choices, KnownFile& file);

}  // namespace ilp::fuzz
