// Receives and sends the PDUs of FileDelivery through the PacketRouter.
#pragma once

#include "fsw/downlink/file_delivery_part.hpp"

namespace ilp {

class FileDeliveryLink : public FileDeliveryPart {
 public:
  using FileDeliveryPart::FileDeliveryPart;

  /// Receives the PDUs that wait in the router.
  void take_in();
  /// Sends PDUs until the router takes no more.
  void send();

 private:
  void receive(std::span<const std::uint8_t> bytes);
  void receive_as_sender(const cfdp::Pdu& pdu);
  /// Acknowledges a Finished of a transaction that has no slot any more.
  void answer_late(const cfdp::Pdu& finished, cfdp::TransactionStatus status);
  /// Sends the first `bytes` bytes of the PDU in the workspace.
  Status send_pdu(std::size_t bytes);
  /// Encodes and sends a PDU. Returns false if the router does not take it. A PDU that cannot be encoded is left out.
  bool answer(const cfdp::Pdu& pdu);
  bool send_late();
  bool send_uplink_answers();
  Status send_item(Slot& slot, const cfdp::SendItem& item);
  /// The transfer with the most urgent PDU, which is `item`; null if nothing is due.
  Slot* most_urgent(cfdp::SendItem& item);
};

}  // namespace ilp
