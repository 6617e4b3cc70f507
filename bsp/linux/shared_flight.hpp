// The primary's part in a flight that several processes share (docs/several-machines.md).
#pragma once

#include "bsp/flight/committed_links.hpp"
#include "bsp/flight/held_camera.hpp"
#include "bsp/flight/node.hpp"
#include "bsp/flight/shared_flight_store.hpp"
#include "hal/clock/real_clock.hpp"

namespace ilp {

/// What the primary has from outside, without the other processes. A packet link may be the null pointer.
struct PrimaryDevices {
  Camera& camera;
  Link& link;
  PacketLink* packets;
  PacketLink* files;
};

class SharedFlight {
 public:
  SharedFlight(Store& store, StoreSharing& sharing, const PrimaryDevices& devices, Clock& clock, StageMask stages,
               bool virtual_time)
      : sharing_(sharing),
        clock_(clock),
        virtual_time_(virtual_time),
        camera_(devices.camera),
        store_(store),
        held_camera_(devices.camera, store_),
        link_(devices.link, store_, sharing),
        packets_(devices.packets, store_, sharing),
        files_(devices.files, store_, sharing),
        node_(store, clock, stages) {}

  /// What the stages of the primary use instead of the database, the camera and the links. A camera that takes images
  /// in real time is never held.
  [[nodiscard]] Store& store() { return store_; }
  [[nodiscard]] Camera& camera() { return virtual_time_ ? static_cast<Camera&>(held_camera_) : camera_; }

  [[nodiscard]] Link& link() { return link_; }
  [[nodiscard]] PacketLink* packets() { return packets_.if_present(); }
  [[nodiscard]] PacketLink* files() { return files_.if_present(); }

  /// Admits the other processes. `mission` has the parameters of the mission file alone.
  Status begin(const MissionParameters& mission);
  /// Connects again, if the connection was lost. False: it is not there yet, try again.
  bool connected(Executive& executive);
  /// Call it in every minor frame. Returns an event about another process, or ok.
  Status keep_alive(const Executive& executive);
  /// In virtual time: whether the flight has to wait for others. Then it has waited a little.
  bool waited(Executive& executive);
  /// In virtual time, when the primary itself has no work: whether all processes are done. Then they are told to end.
  bool done(Executive& executive);

 private:
  /// Whether what nobody waits for is put off in the next minor frame.
  void put_off(Executive& executive, bool late_work);

  StoreSharing& sharing_;
  Clock& clock_;
  bool virtual_time_;
  Camera& camera_;
  SharedFlightStore store_;
  HeldCamera held_camera_;
  CommittedLink link_;
  CommittedPacketLink packets_, files_;
  Node node_;
  std::uint32_t connections_ = 1;
  RealClock board_clock_;  ///< in virtual time that of the flight may stand still
  TimeNs reported_ns_ = 0;
  bool waits_for_end_ = false;
  bool late_work_waits_ = false;
  std::uint32_t frames_put_off_ = 0;  ///< minor frames since late work was done
};

}  // namespace ilp
