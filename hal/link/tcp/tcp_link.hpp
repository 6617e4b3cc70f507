// Space packets back to back over TCP: listens, and serves a bounded number of clients.
#pragma once

#include <array>
#include <cstdint>

#include "cfg/limits.hpp"
#include "hal/clock/clock.hpp"
#include "hal/link/packet_link.hpp"
#include "hal/posix/socket.hpp"

namespace ilp {

struct TcpCounts {
  std::uint32_t accepted = 0;
  std::uint32_t gave_way = 0;  ///< closed: silent for longest when a new client connected
  std::uint32_t garbage = 0;   ///< closed: the data was no sequence of space packets, or ended within one
  std::uint32_t unread = 0;    ///< closed: read nothing for too long
  std::uint32_t skipped = 0;   ///< whole packets that a slow client missed while others got them
};

/// Telemetry goes to every client. The length field of the primary header separates the packets of a client. A packet
/// that is not complete within patience_ns, or a header of another version that no valid one follows, means that the
/// boundaries are lost: the connection is closed. A packet is queued for a client as a whole or not at all, so that a
/// stream never holds a part of one. A client that reads nothing for patience_ns is closed.
/// A new client always gets a place. When all are taken, it replaces a client that has ended sending, else the one
/// whose last accepted packet (accept_sender) is longest ago; clients that never sent one are replaced before those
/// that did.
/// A packet counts as sent when it is queued for a client that has sent an accepted packet. While there is no such
/// client, any client counts.
class TcpLink final : public PacketLink {
 public:
  static constexpr TimeNs patience_ns = 5 * ns_per_s;

  explicit TcpLink(Clock& clock) : clock_(clock) {}
  ~TcpLink();

  /// `io_error` when the address is not ours or already taken.
  Status open(const SocketAddress& local);
  Status address(SocketAddress& local) const { return local_address(socket_, local); }

  /// Also accepts new clients and continues sending. Call it in every minor frame.
  Status receive(std::span<std::uint8_t> buffer, std::size_t& bytes) override;
  Status send(std::span<const std::uint8_t> packet) override;
  void accept_sender() override;

  [[nodiscard]] std::size_t clients() const;
  [[nodiscard]] const TcpCounts& counts() const { return counts_; }

 private:
  struct Client {
    int socket = -1;
    std::uint32_t malformed = 0;  ///< in a row
    bool ended = false;           ///< sends no more, but may still listen; a new client replaces it
    bool accepted = false;        ///< has sent a valid packet
    bool read = false;            ///< was polled for packets at least once; it is not replaced before
    std::uint64_t received = 0;   ///< order of last accepted packets, or of connections
    TimeNs whole_ns = 0;          ///< when the last packet was complete, or no data waited
    TimeNs taken_ns = 0;          ///< when it last read something
    std::size_t in_first = 0, in_size = 0;
    std::size_t out_first = 0, out_size = 0;
    std::array<std::uint8_t, limits::max_packet_bytes> in;
    std::array<std::uint8_t, limits::tcp_queue_bytes> out;
  };

  void accept_client(TimeNs now);
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
  std::size_t next_client_ = 0;
  std::size_t sender_ = 0;  ///< sender of the packet that was received last
  std::uint64_t order_ = 0;
  TcpCounts counts_;
  std::array<Client, limits::max_tcp_clients> clients_{};
};

}  // namespace ilp
