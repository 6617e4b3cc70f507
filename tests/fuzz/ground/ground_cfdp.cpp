// The ground's ends of file delivery: whatever comes, memory is bounded, what is sent is a PDU, and only what is whole
// is kept and confirmed.
#include <string>

#include "fsw/base/crc.hpp"
#include "sim/ground/cfdp/cfdp_receiver.hpp"
#include "sim/ground/cfdp/cfdp_sender.hpp"
#include "tests/fuzz/pdu_choices.hpp"

namespace ilp::fuzz {
namespace {

using ground_cfdp::CfdpReceiver;
using ground_cfdp::CfdpReceiverSettings;
using ground_cfdp::CfdpSender;
using ground_cfdp::CfdpSenderSettings;
using Bytes = std::vector<std::uint8_t>;

constexpr std::uint64_t file_bytes = 3000;

CfdpReceiverSettings small_settings(std::uint8_t choice) {
  CfdpReceiverSettings settings;
  settings.limit = 3;
  settings.max_file_bytes = 8000;
  settings.max_open = 4;
  settings.max_held_bytes = 20000;
  settings.max_closed = 3;
  settings.gaps_in_a_nak = 5;
  settings.gaps_at_once = 12;
  settings.immediate_nak = (choice & 1U) != 0;
  settings.forget_data_before_metadata = (choice & 2U) != 0;
  return settings;
}

class ReceiverRun {
 public:
  explicit ReceiverRun(Choices& choices)
      : choices_(choices),
        settings_(small_settings(choices.byte())),
        receiver_(
            settings_, [this](const Bytes& pdu) { receive(pdu); },
            [this](const std::string& name, const Bytes& file) { return keep(name, file); }) {}

  void operate() {
    const std::uint8_t operation = choices_.byte();
    if (operation % 16 == 0) {
      now_ += choices_.byte();
      receiver_.tick(now_);
    } else if (operation % 16 == 1) {
      receiver_.receive(choices_.bytes(), now_);
    } else if (operation == 2) {
      receiver_.cancel_all(now_);
    } else if (operation % 16 < 6) {
      send_whole(operation);
    } else {
      send(choose(operation));
    }
    // What one PDU brings may be more: it is looked at when the next one comes.
    require(receiver_.held_bytes() <= settings_.max_held_bytes + 300 * 256, "memory of what is held");
    require(receiver_.open() <= settings_.max_open && receiver_.closed() <= settings_.max_closed, "transactions");
  }
  void finish() {
    receiver_.cancel_all(now_);
    for (int i = 0; i < 8; ++i) receiver_.tick(now_ += 100);
    require(receiver_.open() == 0, "a transaction that nobody attends is closed");
    require(receiver_.held_bytes() == 0, "nothing is held for nobody");
  }

 private:
  cfdp::Header header(std::uint8_t sequence) {
    cfdp::Header header;
    header.crc = false;
    header.large_file = (sequence & 8U) != 0;
    header.id_length = header.sequence_length = 8;
    header.source = 1;
    header.sequence = sequence % 8U;
    header.destination = 2;
    return header;
  }
  cfdp::Pdu choose(std::uint8_t operation) {
    cfdp::Pdu pdu = choose_pdu(choices_, header(operation / 16U), file_bytes, capacity_);
    if (pdu.header.large_file && (operation & 1U) != 0) {
      pdu.file_data.offset = choices_.number(8);
      pdu.eof.file_bytes = choices_.number(8);
      pdu.metadata.file_bytes = choices_.number(8);
    }
    pdu.metadata.checksum_type &= 3U;
    return pdu;
  }
  /// So that some transactions come to their end.
  void send_whole(std::uint8_t operation) {
    const Bytes file(choices_.u16() % file_bytes, choices_.byte());
    cfdp::Pdu pdu{.header = header(operation / 16U), .kind = cfdp::PduKind::metadata};
    pdu.metadata.checksum_type = 3;
    pdu.metadata.file_bytes = file.size();
    pdu.metadata.source_name = pdu.metadata.destination_name = name_;
    if (operation % 16 != 3) send(pdu);
    pdu.kind = cfdp::PduKind::file_data;
    pdu.file_data.bytes = Octets(file).first(operation % 16 == 4 ? file.size() / 2 : file.size());
    send(pdu);
    pdu.kind = cfdp::PduKind::eof;
    pdu.eof.checksum = crc32(file);
    pdu.eof.file_bytes = file.size();
    send(pdu);
  }
  void send(const cfdp::Pdu& pdu) {
    std::array<std::uint8_t, 4096> octets;
    std::size_t bytes = 0;
    if (!cfdp::encode(pdu, octets, bytes).ok()) return;
    receiver_.receive(Octets(octets).first(bytes), now_);
  }
  void receive(const Bytes& octets) {
    cfdp::Pdu pdu;
    require(cfdp::decode(octets, pdu).ok(), "a PDU that cannot be read");
    require(pdu.header.toward_sender, "a PDU to nobody");
    if (pdu.kind == cfdp::PduKind::finished && pdu.finished.file_status == cfdp::FileStatus::retained) {
      require(kept_any_, "a file that was not kept");
    }
    if (pdu.kind != cfdp::PduKind::nak) return;
    const std::size_t count = cfdp::gap_count(pdu.header, pdu.nak);
    require(count <= settings_.gaps_in_a_nak, "gaps of a NAK");
    std::uint64_t end = 0;
    for (std::size_t i = 0; i < count; ++i) {
      const cfdp::Gap gap = cfdp::gap_at(pdu.header, pdu.nak, i);
      if (gap.begin == 0 && gap.end == 0) continue;
      require(gap.begin >= end && gap.begin < gap.end && gap.end <= settings_.max_file_bytes, "gaps");
      end = gap.end;
    }
  }
  bool keep(const std::string&, const Bytes& file) {
    require(file.size() <= settings_.max_file_bytes, "a file larger than any");
    const bool good = (file.size() & 1U) == 0;
    kept_any_ = kept_any_ || good;
    return good;
  }

  static constexpr std::uint8_t name_[4] = {'f', 'i', 'l', 'e'};
  Choices& choices_;
  CfdpReceiverSettings settings_;
  bool kept_any_ = false;
  CfdpReceiver receiver_;
  PduCapacity capacity_;
  double now_ = 0;
};

class SenderRun {
 public:
  explicit SenderRun(Choices& choices)
      : choices_(choices),
        sender_(settings(), [this](const Bytes& pdu) { receive(pdu); }),
        file_(choices.u16() % file_bytes) {
    sequence_ = sender_.put("file.ini", file_, now_, 1 + choices.byte());
  }
  void operate() {
    const std::uint8_t operation = choices_.byte();
    sent_bytes_ = 0;
    if (operation % 16 == 0) {
      sender_.tick(now_ += choices_.byte());
    } else if (operation % 16 == 1) {
      sender_.receive(choices_.bytes(), now_);
    } else {
      const cfdp::Header& header = sender_.transfer(sequence_).header;
      const cfdp::Pdu pdu = choose_pdu(choices_, header, file_.size(), capacity_);
      std::array<std::uint8_t, 4096> octets;
      std::size_t bytes = 0;
      if (cfdp::encode(pdu, octets, bytes).ok()) sender_.receive(Octets(octets).first(bytes), now_);
    }
    require(sent_bytes_ <= file_.size(), "more than the file for one request");
  }
  void finish() {
    for (int i = 0; i < settings().limit + 2; ++i) sender_.tick(now_ += 10);
    require(sender_.transfer(sequence_).state != CfdpSender::State::going, "a sender that never stops");
  }

 private:
  static CfdpSenderSettings settings() {
    CfdpSenderSettings settings{.limit = 5};
    return settings;
  }
  void receive(const Bytes& octets) {
    cfdp::Pdu pdu;
    require(cfdp::decode(octets, pdu).ok(), "a PDU that cannot be read");
    if (pdu.kind != cfdp::PduKind::file_data) return;
    require(pdu.file_data.offset + pdu.file_data.bytes.size() <= file_.size(), "data beyond the file");
    sent_bytes_ += pdu.file_data.bytes.size();
  }

  Choices& choices_;
  CfdpSender sender_;
  Bytes file_;
  std::uint64_t sequence_ = 0, sent_bytes_ = 0;
  PduCapacity capacity_;
  double now_ = 0;
};

template <typename Run>
void run(Choices& choices) {
  Run run(choices);
  for (int i = 0; i < 200 && !choices.empty(); ++i) run.operate();
  run.finish();
}

}  // namespace

void ground_cfdp(Octets input) {
  Choices choices(input);
  if ((choices.byte() & 1U) != 0) {
    run<SenderRun>(choices);
  } else {
    run<ReceiverRun>(choices);
  }
}

}  // namespace ilp::fuzz
