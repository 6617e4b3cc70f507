// What the primary of a flight that several processes share does for the others (docs/several-machines.md).
#pragma once

#include "bsp/flight/committed_links.hpp"
#include "bsp/flight/held_camera.hpp"
#include "bsp/flight/node.hpp"
#include "bsp/flight/shared_flight_store.hpp"
#include "hal/clock/real_clock.hpp"

namespace ilp {

/// The camera and the links of the primary. A packet link may be the null pointer.
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

  /// The store, camera and links that the stages of the primary use in place of the original ones. The camera is a
  /// HeldCamera in virtual time only.
  [[nodiscard]] Store& store() { return store_; }
  [[nodiscard]] Camera& camera() { return virtual_time_ ? static_cast<Camera&>(held_camera_) : camera_; }

  [[nodiscard]] Link& link() { return link_; }
  [[nodiscard]] PacketLink* packets() { return packets_.if_present(); }
  [[nodiscard]] PacketLink* files() { return files_.if_present(); }

  /// Lets the other processes join. `mission` has only the parameters of the mission file.
  Status begin(const MissionParameters& mission);
  /// Whether the store is connected. If the connection was lost, connects again and restores the stages; if that fails,
  /// waits 200 ms and returns false.
  bool connected(Executive& executive);
  /// Writes the primary's record every 2 s and flushes the store. Call it in every minor frame. Returns an event about
  /// another process, an error of the disk, or ok.
  Status keep_alive(const Executive& executive);
  /// In virtual time: whether mission time must not advance, because the camera or the end of the flight waits for
  /// other processes. Waits up to 20 ms for them then.
  bool waited(Executive& executive);
  /// In virtual time, when the primary itself has no work: whether all processes are done. Tells them to end then.
  bool done(Executive& executive);

 private:
  /// Sets whether work that no process waits for is put off in the next minor frame.
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
  std::uint32_t connections_ = 1;     ///< connections to the store until now
  RealClock board_clock_;             ///< the flight's own clock may stand still in virtual time
  TimeNs reported_ns_ = 0;            ///< when the primary's record was last written, by `board_clock_`
  bool waits_for_end_ = false;        ///< done() was called
  bool late_work_waits_ = false;      ///< work was put off in the latest minor frame
  std::uint32_t frames_put_off_ = 0;  ///< consecutive minor frames in which work was put off
};

}  // namespace ilp
