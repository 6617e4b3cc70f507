// A packet link over TCP: listens, and exchanges space packets, one after another, with a bounded number of clients.
#pragma once

#include <array>
#include <cstdint>

#include "cfg/limits.hpp"
#include "hal/clock/clock.hpp"
#include "hal/link/packet_link.hpp"
#include "hal/posix/socket.hpp"

namespace ilp {

struct TcpCounts {
  std::uint32_t accepted = 0;  ///< clients that have connected
  std::uint32_t gave_way = 0;  ///< clients closed because a new client needed their slot
  std::uint32_t garbage = 0;   ///< clients closed because their data was no sequence of complete space packets
  std::uint32_t unread = 0;    ///< clients closed because they read nothing for too long
  std::uint32_t skipped = 0;   ///< packets that a slow client missed while another one got them
};

/// Telemetry goes to every client. A packet is queued for a client completely or not at all. A client that reads
/// nothing for patience_ns is closed.
///
/// The length field of the primary header separates the packets that a client sends. The packet boundaries are lost if
/// a packet is not complete within patience_ns, or if a header of another version is not followed by a valid header.
/// The connection is then closed.
///
/// If all slots are taken, a new client replaces another one: first a client that has ended sending, then a client that
/// never sent an accepted packet (accept_sender), then the client whose last accepted packet is oldest.
///
/// send() returns ok when the packet is queued for a client that has sent an accepted packet. While there is no such
/// client, any client suffices.
class TcpLink final : public PacketLink {
 public:
  static constexpr TimeNs patience_ns = 5 * ns_per_s;

  explicit TcpLink(Clock& clock) : clock_(clock) {}
  ~TcpLink();

  /// Listens at an address of this board. Returns `io_error` (first value: errno) if the address is not one of this
  /// board's or is in use.
  Status open(const SocketAddress& local);
  /// Reads the address at which the link listens.
  Status address(SocketAddress& local) const { return local_address(socket_, local); }

  /// Reads the next packet of any client. Also accepts new clients and continues sending, so call it in every minor
  /// frame.
  Status receive(std::span<std::uint8_t> buffer, std::size_t& bytes) override;
  Status send(std::span<const std::uint8_t> packet) override;
  void accept_sender() override;

  /// Number of connected clients.
  [[nodiscard]] std::size_t clients() const;
  [[nodiscard]] const TcpCounts& counts() const { return counts_; }

 private:
  struct Client {
    int socket = -1;
    std::uint32_t malformed = 0;  ///< consecutive packets with a header of another version
    bool ended = false;           ///< sends no more, but may still read
    bool accepted = false;        ///< has sent an accepted packet
    bool read = false;            ///< was polled for packets at least once; it is not replaced before
    std::uint64_t received = 0;   ///< rank of its last accepted packet, or of its connection, in time
    TimeNs whole_ns = 0;          ///< when its last packet was complete, or no data waited
    TimeNs taken_ns = 0;          ///< when it last read something, or nothing was queued for it
    std::size_t in_first = 0, in_size = 0;
    std::size_t out_first = 0, out_size = 0;
    std::array<std::uint8_t, limits::max_packet_bytes> in;
    std::array<std::uint8_t, limits::tcp_queue_bytes> out;
  };

  void accept_client(TimeNs now);
  /// The slot that a new client gets; nullptr: none at present.
  [[nodiscard]] Client* place_for_new();
  void admit(int socket, TimeNs now, Client& place);
  void read(Client& client, TimeNs now);
  bool next_packet(Client& client, TimeNs now, std::span<const std::uint8_t>& packet);
  void flush(Client& client, TimeNs now);
  [[nodiscard]] static bool has_capacity(const Client& client, std::span<const std::uint8_t> packet);
  static void enqueue(Client& client, std::span<const std::uint8_t> packet);
  void drop(Client& client, std::uint32_t& reason);

  Clock& clock_;
  int socket_ = -1;
  std::size_t next_client_ = 0;  ///< client with which the next receive() begins
  std::size_t sender_ = 0;       ///< client whose packet was received last
  std::uint64_t order_ = 0;      ///< latest Client::received
  TcpCounts counts_;
  std::array<Client, limits::max_tcp_clients> clients_{};
};

}  // namespace ilp
