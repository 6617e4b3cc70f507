// PDUs made of choices: most of them of one transaction and with sizes near those of its file, so that they are
// accepted.
#pragma once

#include <array>

#include "fsw/packets/cfdp_pdu.hpp"
#include "tests/fuzz/targets.hpp"

namespace ilp::fuzz {

/// The spans of a PDU that was chosen point into this, or into the input.
struct PduCapacity {
  std::array<std::uint8_t, 16 * 64> gaps{};
};

/// 0 to about `scale`, its borders often; now and then anything.
std::uint64_t choose_size(Choices& choices, std::uint64_t scale);
/// A PDU of the transaction of `header`.
cfdp::Pdu choose_pdu(Choices& choices, const cfdp::Header& header, std::uint64_t file_bytes, PduCapacity& capacity);

}  // namespace ilp::fuzz
