// The packets of FileDelivery: what comes from the router, and what it takes.
#pragma once

#include "fsw/downlink/file_delivery_part.hpp"

namespace ilp {

class FileDeliveryLink : public FileDeliveryPart {
 public:
  using FileDeliveryPart::FileDeliveryPart;

  void take_in();
  void send();

 private:
  void receive(std::span<const std::uint8_t> bytes);
  void receive_as_sender(const cfdp::Pdu& pdu);
  void answer_late(const cfdp::Pdu& finished, cfdp::TransactionStatus status);
  /// The bytes in the workspace.
  Status send_pdu(std::size_t bytes);
  /// False when the router takes no more. What cannot be encoded is left out.
  bool answer(const cfdp::Pdu& pdu);
  bool send_late();
  bool send_uplink_answers();
  Status send_item(Slot& slot, const cfdp::SendItem& item);
  Slot* most_urgent(cfdp::SendItem& item);
};

}  // namespace ilp
