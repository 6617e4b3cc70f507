#include "fsw/packets/cfdp_pdu.hpp"

#include <algorithm>
#include <vector>

#include "fsw/packets/crc16.hpp"
#include "tests/fuzz/targets.hpp"

namespace ilp::fuzz {
namespace {

void look_at(Octets octets) {
  cfdp::Pdu pdu;
  const Status status = cfdp::decode(octets, pdu);
  if (!status.ok()) {
    require(status.is(StatusCode::pdu_rejected), "another reason");
    require(status.a > 0 && status.a < static_cast<std::int64_t>(cfdp::PduFault::count), "no reason");
    return;
  }
  if (pdu.kind == cfdp::PduKind::nak) {
    for (std::size_t i = 0; i < cfdp::gap_count(pdu.header, pdu.nak); ++i) {
      static_cast<void>(cfdp::gap_at(pdu.header, pdu.nak, i));
    }
  }
  for (Octets options : {pdu.kind == cfdp::PduKind::metadata ? pdu.metadata.options : Octets{},
                         pdu.kind == cfdp::PduKind::eof ? pdu.eof.options : Octets{},
                         pdu.kind == cfdp::PduKind::finished ? pdu.finished.options : Octets{}}) {
    const std::size_t most = options.size();
    std::size_t found = 0;
    cfdp::Tlv tlv;
    while (cfdp::next_tlv(options, tlv)) require(++found <= most, "more options than octets");
  }
  // Reserved bits may differ; everything that is said may not.
  std::vector<std::uint8_t> again(octets.size());
  std::size_t bytes = 0;
  require(cfdp::encode(pdu, again, bytes).ok() && bytes == octets.size(), "length of what was read");
  cfdp::Pdu second;
  require(cfdp::decode(again, second).ok(), "reading what was written");
  std::vector<std::uint8_t> third(again.size());
  require(cfdp::encode(second, third, bytes).ok() && bytes == third.size() && third == again, "what was written");
}

}  // namespace

void cfdp_pdu(Octets input) {
  look_at(input);
  // With the length that it has, and a CRC where it wants one.
  if (input.size() < 4 || input.size() > 4096) return;
  std::vector<std::uint8_t> mended(input.begin(), input.end());
  const std::size_t header = 4 + 2 * (((mended[3] >> 4U) & 7U) + 1U) + (mended[3] & 7U) + 1U;
  if (mended.size() < header) return;
  mended[0] = static_cast<std::uint8_t>((mended[0] & 0x1FU) | 0x20U);
  const bool crc = (mended[0] & 2U) != 0;
  if (crc) mended.resize(mended.size() + 2);
  const std::size_t length = mended.size() - header;
  mended[1] = static_cast<std::uint8_t>(length >> 8U);
  mended[2] = static_cast<std::uint8_t>(length);
  if (crc) {
    const std::uint16_t check = crc16(Octets(mended).first(mended.size() - 2));
    mended[mended.size() - 2] = static_cast<std::uint8_t>(check >> 8U);
    mended[mended.size() - 1] = static_cast<std::uint8_t>(check);
  }
  look_at(mended);
}

}  // namespace ilp::fuzz
