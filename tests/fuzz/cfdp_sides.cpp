// The two state machines of a transaction. Operations are chosen by the input; between them everything that wants to go
// goes.
#include <algorithm>
#include <cstring>
#include <memory>

#include "fsw/packets/cfdp_receiver.hpp"
#include "fsw/packets/cfdp_sender.hpp"
#include "tests/fuzz/pdu_choices.hpp"

namespace ilp::fuzz {
namespace {

// More than the largest file of these targets in the smallest segments, twice, and a list of gaps.
constexpr int most_in_a_row = 2000;
constexpr std::uint32_t most_file_bytes = 4000;

cfdp::Header choose_header(Choices& choices) {
  cfdp::Header header;
  const std::uint8_t flags = choices.byte();
  header.crc = (flags & 1U) != 0;
  header.large_file = (flags & 2U) != 0;
  header.id_length = static_cast<std::uint8_t>(1U + ((flags >> 2U) & 7U));
  header.sequence_length = static_cast<std::uint8_t>(1U + (flags >> 5U));
  header.source = 1;
  header.sequence = choices.byte();
  header.destination = 2;
  return header;
}

/// What goes out is a PDU that says again what was meant.
void check(const cfdp::Pdu& pdu) {
  std::array<std::uint8_t, limits::max_pdu_bytes> octets;
  std::size_t bytes = 0;
  require(cfdp::encode(pdu, octets, bytes).ok(), "a PDU that cannot be written");
  cfdp::Pdu read;
  require(cfdp::decode(Octets(octets).first(bytes), read).ok() && read.kind == pdu.kind, "a PDU that cannot be read");
}

class SenderRun {
 public:
  explicit SenderRun(Choices& choices) : choices_(choices) {
    order_.header = choose_header(choices);
    order_.file_bytes = choices.u16() % most_file_bytes;
    order_.checksum = choices.u32();
    std::strcpy(order_.name, "file");
    settings_.segment_bytes = 16U + choices.u16() % 1000U;
    settings_.metadata_copies = choices.byte() % 4U;
    settings_.prompt_ns = (choices.byte() & 1U) != 0 ? 30 * ns_per_s : 0;
    sender_.begin(order_, settings_);
  }

  void operate() {
    const std::uint8_t operation = choices_.byte();
    switch (operation % 8) {
      case 0:
      case 1:
      case 2:
        sender_.receive(choose_pdu(choices_, order_.header, order_.file_bytes, capacity_), now_);
        break;
      case 3:
        now_ += choices_.byte() * ns_per_s;
        sender_.tick(now_);
        break;
      case 4:
        sender_.suspend();
        break;
      case 5:
        sender_.unsuspend(now_);
        break;
      case 6:
        if (operation == 6) sender_.cancel(choices_.u32(), now_);
        sender_.prompt();
        break;
      default:
        resume();
        break;
    }
    const auto most = static_cast<int>(choices_.byte());
    drain(most < 128 ? most : most_in_a_row);
  }
  /// The ground says no more: it comes to rest.
  void finish() {
    drain(most_in_a_row);
    for (int i = 0; i < 20; ++i) {
      now_ += 3600 * ns_per_s;
      sender_.tick(now_);
      drain(most_in_a_row);
    }
  }

 private:
  void resume() {
    FixedVector<cfdp::Segment, 8> gaps;
    const std::size_t count = choices_.byte() % 8U;
    for (std::size_t i = 0; i < count; ++i) {
      static_cast<void>(gaps.push_back({static_cast<std::uint32_t>(choose_size(choices_, order_.file_bytes)),
                                        static_cast<std::uint32_t>(choose_size(choices_, order_.file_bytes))}));
    }
    const auto progress = static_cast<std::uint32_t>(choose_size(choices_, order_.file_bytes));
    sender_.resume(order_, settings_, progress, (choices_.byte() & 1U) != 0, {gaps.data(), gaps.size()});
  }
  void drain(int most) {
    cfdp::SendItem item;
    for (int i = 0; i < most; ++i) {
      if (!sender_.next(item)) return;
      cfdp::Pdu pdu;
      sender_.build(item, pdu);
      if (item.kind == cfdp::PduKind::file_data) {
        require(item.segment.begin < item.segment.end && item.segment.end <= order_.file_bytes, "data beyond the file");
        require(item.segment.end - item.segment.begin <= settings_.segment_bytes, "a segment that is too long");
        pdu.file_data.bytes = Octets(file_).subspan(item.segment.begin, item.segment.end - item.segment.begin);
      }
      check(pdu);
      sender_.sent(item, now_);
      require(sender_.progress() <= order_.file_bytes, "progress beyond the file");
    }
    require(most < most_in_a_row, "a sender that never stops");
  }

  Choices& choices_;
  cfdp::SendOrder order_;
  cfdp::SenderSettings settings_;
  cfdp::Sender sender_;
  PduCapacity capacity_;
  TimeNs now_ = 0;
  std::array<std::uint8_t, most_file_bytes> file_{};
};

class ReceiverRun {
 public:
  explicit ReceiverRun(Choices& choices) : choices_(choices) {
    header_ = choose_header(choices);
    settings_.crc = header_.crc;
    file_bytes_ = choices.u16() % most_file_bytes;
    receiver().begin(header_, settings_, now_);
  }

  void operate() {
    const std::uint8_t operation = choices_.byte();
    switch (operation % 8) {
      case 0:
        now_ += choices_.byte() * ns_per_s;
        receiver().tick(now_);
        break;
      case 1:
        conclude();
        break;
      case 2:
        if (operation == 2) restart();
        break;
      default:
        receiver().receive(choose_pdu(choices_, header_, file_bytes_, capacity_), now_);
        break;
    }
    check_gaps();
    const auto most = static_cast<int>(choices_.byte());
    drain(most < 128 ? most : most_in_a_row);
  }
  void finish() {
    if (receiver().phase() == cfdp::ReceivePhase::whole) conclude();
    for (int i = 0; i < 20; ++i) {
      now_ += 3600 * ns_per_s;
      receiver().tick(now_);
      drain(most_in_a_row);
    }
    require(receiver().phase() == cfdp::ReceivePhase::closed, "a transaction that nobody attends is abandoned");
  }

 private:
  void conclude() {
    if (receiver().phase() == cfdp::ReceivePhase::whole) {
      receiver().conclude(cfdp::Condition::no_error, cfdp::FileStatus::retained, now_);
    } else {
      receiver().conclude(cfdp::Condition::cancel_request_received, cfdp::FileStatus::discarded, now_);
    }
  }
  void restart() {
    const cfdp::OpenReception open = receiver().open();
    if (open.used) receiver().resume(open, settings_, now_);
  }
  void check_gaps() {
    std::uint32_t end = 0;
    for (const cfdp::Segment& segment : receiver().missing()) {
      require(segment.begin >= end && segment.end > segment.begin && segment.end <= limits::max_uplink_bytes, "gaps");
      end = segment.end;
    }
    require(receiver().file().size() <= limits::max_uplink_bytes, "size of the file");
  }
  void drain(int most) {
    cfdp::PduKind kind = cfdp::PduKind::count;
    for (int i = 0; i < most; ++i) {
      if (!receiver().next(kind)) return;
      cfdp::Pdu pdu;
      receiver().build(kind, pdu);
      check(pdu);
      require(pdu.keep_alive.progress_bytes <= limits::max_uplink_bytes, "more than a file can hold");
      require(pdu.nak.scope.end <= limits::max_uplink_bytes, "gaps beyond what a file can hold");
      receiver().sent(kind, now_);
    }
    require(most < most_in_a_row, "a receiver that never stops");
  }
  /// Large: one for all runs.
  static cfdp::Receiver& receiver() {
    static cfdp::Receiver one;
    return one;
  }

  Choices& choices_;
  cfdp::Header header_;
  cfdp::ReceiverSettings settings_;
  std::uint32_t file_bytes_ = 0;
  PduCapacity capacity_;
  TimeNs now_ = 0;
};

template <typename Run>
void run(Octets input) {
  Choices choices(input);
  Run run(choices);
  for (int i = 0; i < 200 && !choices.empty(); ++i) run.operate();
  run.finish();
}

}  // namespace

void cfdp_sender(Octets input) {
  run<SenderRun>(input);
}

void cfdp_receiver(Octets input) {
  run<ReceiverRun>(input);
}

}  // namespace ilp::fuzz
