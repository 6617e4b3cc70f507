#include "tests/fuzz/pdu_choices.hpp"

#include "cfg/limits.hpp"

namespace ilp::fuzz {

std::uint64_t choose_size(Choices& choices, std::uint64_t scale) {
  const std::uint8_t how = choices.byte();
  switch (how % 16) {
    case 0:
      return 0;
    case 1:
      return scale;
    case 2:
      return scale + 1;
    case 3:
      return choices.u32();
    case 4:
      return scale / 2;
    case 5:
      return choices.byte();
    case 8:
      return limits::max_uplink_bytes - choices.byte();
    default:
      return choices.u16() % (scale + 2);
  }
}

cfdp::Pdu choose_pdu(Choices& choices, const cfdp::Header& header, std::uint64_t file_bytes, PduCapacity& capacity) {
  cfdp::Pdu pdu;
  pdu.header = header;
  pdu.kind = static_cast<cfdp::PduKind>(choices.byte() % static_cast<unsigned>(cfdp::PduKind::count));
  switch (pdu.kind) {
    case cfdp::PduKind::metadata:
      pdu.metadata.checksum_type = static_cast<std::uint8_t>(choices.byte() & 0x0FU);
      pdu.metadata.file_bytes = choose_size(choices, file_bytes);
      pdu.metadata.source_name = choices.bytes();
      pdu.metadata.destination_name = choices.bytes();
      break;
    case cfdp::PduKind::file_data:
      pdu.file_data.offset = choose_size(choices, file_bytes);
      pdu.file_data.bytes = choices.bytes();
      break;
    case cfdp::PduKind::eof:
      pdu.eof.condition = static_cast<cfdp::Condition>(choices.byte() & 0x0FU);
      pdu.eof.checksum = choices.u32();
      pdu.eof.file_bytes = choose_size(choices, file_bytes);
      break;
    case cfdp::PduKind::finished:
      pdu.finished.condition = static_cast<cfdp::Condition>(choices.byte() & 0x0FU);
      pdu.finished.incomplete = (choices.byte() & 1U) != 0;
      pdu.finished.file_status = static_cast<cfdp::FileStatus>(choices.byte() & 3U);
      break;
    case cfdp::PduKind::ack:
      pdu.ack.of_finished = (choices.byte() & 1U) != 0;
      pdu.ack.condition = static_cast<cfdp::Condition>(choices.byte() & 0x0FU);
      pdu.ack.status = static_cast<cfdp::TransactionStatus>(choices.byte() & 3U);
      break;
    case cfdp::PduKind::nak: {
      pdu.nak.scope = {choose_size(choices, file_bytes), choose_size(choices, file_bytes)};
      const std::size_t count = choices.byte() % 64;
      std::size_t bytes = 0;
      for (std::size_t i = 0; i < count && !choices.empty(); ++i) {
        const cfdp::Gap gap = {choose_size(choices, file_bytes), choose_size(choices, file_bytes)};
        bytes += cfdp::write_gap(header, gap, capacity.gaps.data() + bytes);
      }
      pdu.nak.gaps = {capacity.gaps.data(), bytes};
      break;
    }
    case cfdp::PduKind::prompt:
      pdu.prompt.keep_alive = (choices.byte() & 1U) != 0;
      break;
    case cfdp::PduKind::keep_alive:
      pdu.keep_alive.progress_bytes = choose_size(choices, file_bytes);
      break;
    case cfdp::PduKind::count:
      break;
  }
  return pdu;
}

}  // namespace ilp::fuzz
