// ST[01] request verification: the reports on a telecommand.
#pragma once

#include <cstdint>
#include <span>

#include "fsw/packets/tailoring.hpp"

namespace ilp {

/// Subtypes; the even ones report failures.
namespace verification {
inline constexpr std::uint8_t service = 1;
inline constexpr std::uint8_t acceptance = 1, acceptance_failed = 2, start = 3, start_failed = 4, progress = 5,
                              progress_failed = 6, completion = 7, completion_failed = 8, routing_failed = 10;
}  // namespace verification

struct VerificationReport {
  std::uint8_t subtype = verification::acceptance;
  std::uint32_t request = 0;                   ///< the first four octets of the telecommand
  std::uint32_t step = 0;                      ///< only in reports of progress
  std::uint32_t code = 0;                      ///< number of StatusCode; only in reports of failures
  std::span<const std::uint8_t> failure_data;  ///< only in reports of failures
};

void encode_verification(const Tailoring& tailoring, const VerificationReport& report, ByteWriter& out);
/// Decodes a report of `subtype`. Returns `request_malformed` (first value: offset in `data`) if the length is wrong.
Status decode_verification(const Tailoring& tailoring, std::uint8_t subtype, std::span<const std::uint8_t> data,
                           VerificationReport& report);

}  // namespace ilp
