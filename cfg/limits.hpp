// Every compile-time capacity of the flight software, in one place. Static memory follows from these numbers:
// `ilp-onboard --memory-map` prints it. What differs between machines is in the profile, which the CMake option
// ILP_PROFILE names: a folder of cfg/profiles, or any folder with a profile.hpp.
#pragma once

#include <cstddef>
#include <cstdint>

#include "profile.hpp"

namespace ilp::limits {

inline constexpr std::size_t flight_stack_bytes = std::size_t{512} << 10U;  // 64 KiB used in the default flight
inline constexpr std::size_t worker_stack_bytes = std::size_t{128} << 10U;
// The C library's requests before the heap is sealed; 72 KiB of it is the reserve of the C++ run-time. The libraries of
// a server's client need more when they are loaded.
inline constexpr std::size_t early_heap_bytes = std::size_t{128} << 10U;
inline constexpr std::size_t postgres_early_heap_bytes = std::size_t{512} << 10U;

inline constexpr std::size_t max_image_pixels =
    static_cast<std::size_t>(max_image_width) * static_cast<std::size_t>(max_image_height);
// A rolling shutter moves no point by more rows until the middle row is exposed.
inline constexpr std::int32_t max_rolling_rows = max_image_height / 20;
inline constexpr std::size_t spare_image_pixels =
    static_cast<std::size_t>(max_rolling_rows) * static_cast<std::size_t>(max_image_width);
inline constexpr std::int32_t max_image_side = max_image_width > max_image_height ? max_image_width : max_image_height;
inline constexpr std::int32_t min_image_side = 64;

// Pictures of a source may be larger than the flight's images: up to 12 megapixels of common sensors (4056 x 3040,
// 4608 x 2592). They are reduced row by row.
inline constexpr std::int32_t max_sensor_side = 4608;
// One row of blocks of a JPEG picture, and tables: 236 KiB used at worst.
inline constexpr std::size_t jpeg_arena_bytes = std::size_t{256} << 10U;

// Camera driven through V4L2: the driver's buffers, the frames held until the nearest one is known, reports, bytes of a
// row
inline constexpr std::size_t max_camera_buffers = 16;
inline constexpr std::size_t max_held_frames = 3;
inline constexpr std::size_t max_camera_updates = 16;
inline constexpr std::size_t max_camera_row_bytes = 2 * static_cast<std::size_t>(max_sensor_side) + 4096;

// The latest frames' images that were read, and the newest one that was written, stay in memory.
inline constexpr std::size_t cached_images = 4;

// Image pyramid and overlap: the coarsest level has at most 32 px a side
inline constexpr int max_pyramid_levels = max_image_side > 1024 ? 7 : 6;

// Features and matches
inline constexpr std::size_t max_matches = max_corners;
inline constexpr int max_patch_side = 21;

// Two views
inline constexpr std::size_t max_ransac_trials = 2000;

// Multiview: one window of bundle adjustment
inline constexpr std::size_t max_bundle_cameras = max_window_keyframes + max_fixed_keyframes;
inline constexpr std::size_t max_bundle_observations = 6 * max_bundle_points;
inline constexpr std::size_t max_tracks = max_bundle_points;
inline constexpr std::size_t max_track_length = max_bundle_cameras;

// Self-calibration: keyframes of a set (masks of tracks have 8 bits) and points followed through them
inline constexpr std::size_t max_calibration_views = 6;
inline constexpr std::size_t max_calibration_tracks = max_matches;
// Keyframes whose planes and measurements give the focal length
inline constexpr std::size_t max_plane_views = 64;

// Final points of one batch as bytes: every track with ten observations of 16 bytes and 32 bytes of its own
inline constexpr std::size_t max_structure_bytes = max_tracks * (32 + 10 * 16);

// Stereo: a rectified image stands along the baseline, at any angle to the original: the diagonal of a 4:3 image is 5/4
// of its longer side
inline constexpr std::int32_t max_rectified_width = max_image_side + max_image_side / 4;
inline constexpr std::int32_t max_rectified_height = max_rectified_width;
inline constexpr std::size_t max_rectified_pixels =
    static_cast<std::size_t>(max_rectified_width) * static_cast<std::size_t>(max_rectified_height);

// Terrain
inline constexpr std::size_t richness_histogram_bins = 64;

// Places: ground that is recognised
inline constexpr std::size_t place_features = 256;          ///< of a keyframe that the chain of pairs holds
inline constexpr std::size_t max_place_features = 1024;     ///< of one whose strip is weakly connected
inline constexpr std::size_t max_place_patches = 400;       ///< patches of a keyframe's image that are kept
inline constexpr std::size_t max_link_points = 128;         ///< points that both keyframes of a link see
inline constexpr std::size_t max_places = 4096;             ///< keyframes that can be found by their appearance
inline constexpr std::size_t indexed_place_features = 100;  ///< of one keyframe
inline constexpr std::size_t place_vocabulary = 2048;       ///< descriptors that represent their neighbourhood
inline constexpr std::size_t place_vocabulary_places = 32;  ///< the first keyframes, from which they are drawn
inline constexpr std::size_t place_candidates = 8;          ///< by place, and by appearance, of a keyframe
inline constexpr std::size_t max_place_candidates = 24;     ///< of one whose strip is weakly connected
inline constexpr std::size_t max_near_places = 32;          ///< whose ground is expected in the image of a new one
inline constexpr std::int64_t max_links_per_keyframe = 16;  ///< of a weakly connected one; link_id() counts with it

// Products
inline constexpr int max_quality_layers = 8;
inline constexpr int max_wavelet_levels = 6;
/// A datagram of the vehicle's computer; of a larger one the packets that end beyond it are lost.
inline constexpr std::size_t max_vehicle_datagram_bytes = 2048;
/// Samples of the vehicle's navigation at hand: 400 s at 10 Hz.
inline constexpr std::size_t max_navigation_samples = 4096;
inline constexpr std::size_t max_product_bytes = max_image_pixels * 2 + 65536;
inline constexpr std::size_t max_metadata_bytes = 4096;

// Images at commanded places
inline constexpr std::size_t max_place_captures = 8;
inline constexpr std::size_t max_track_places = 8;  ///< latest places of the vehicle that the forecast goes by

// Downlink
inline constexpr std::size_t max_overdue_passes = 16;
inline constexpr std::size_t max_plan_candidates = 256;  ///< products that one plan weighs against each other
inline constexpr std::size_t max_exact_candidates =
    64;                                          ///< with at most this many, a plan also searches for the best fit
inline constexpr std::size_t plan_cells = 1024;  ///< steps into which this search divides the bytes of a pass
inline constexpr std::size_t max_refine_requests = 32;  ///< requests of the ground; the oldest are dropped

// Telecommands and telemetry
inline constexpr std::size_t max_report_bytes = 1400;     ///< of telemetry: one Ethernet frame
inline constexpr std::size_t max_scheduled_bytes = 1024;  ///< of a telecommand that waits for its time
inline constexpr std::size_t max_list_items = 64;
inline constexpr std::size_t max_event_list = 128;
inline constexpr std::size_t max_scheduled = 128;     ///< requests of the time-based schedule
inline constexpr std::size_t max_open_requests = 64;  ///< telecommands that wait for their completion
inline constexpr std::size_t message_counters = 64;   ///< types of messages and destinations that are counted apart
inline constexpr std::size_t telemetry_ring_bytes = std::size_t{128} << 10U;
// Packet link
inline constexpr std::size_t max_packet_bytes = 6 + 65536;  ///< the largest packet that a length field can state
inline constexpr std::size_t max_datagrams_per_pump = 64;   ///< per link and minor frame; more wait in the link
inline constexpr std::size_t max_security_associations = 4;
inline constexpr std::size_t max_stations = 8;  ///< destinations of a link of datagrams
inline constexpr std::size_t max_tcp_clients = 4;
inline constexpr std::size_t tcp_queue_bytes = std::size_t{128} << 10U;  ///< per client
inline constexpr std::size_t command_ring_bytes = std::size_t{128} << 10U;
inline constexpr std::size_t pdu_ring_bytes = std::size_t{256} << 10U;

// Files by CFDP
inline constexpr std::size_t max_transfers = 64;   ///< files on their way to the ground
inline constexpr std::size_t max_file_gaps = 256;  ///< of one file, asked for by its receiver
inline constexpr std::size_t max_pdu_bytes = 2048;
/// A product whole or as a refinement, or the points of a keyframe with their records.
inline constexpr std::size_t max_transfer_bytes =
    (max_product_bytes > max_structure_bytes ? max_product_bytes : max_structure_bytes) + 32768;
/// PostgreSQL's library holds a blob in the message that brings it, in the answer, and while it makes room for them.
inline constexpr std::size_t postgres_heap_bytes = 8 * max_transfer_bytes + (std::size_t{2} << 20U);
inline constexpr std::size_t max_closed_transfers = 64;  ///< kept to answer late PDUs
inline constexpr std::size_t max_uplinks = 2;            ///< concurrent uplinked files
inline constexpr std::size_t max_uplink_bytes = 65536;
inline constexpr std::size_t max_uplink_records = 8;  ///< the newest uplinked files stay on board

// Maps of orbiters (docs/map-relative.md)
inline constexpr std::size_t max_map_layers = 2;
inline constexpr std::size_t max_map_tiles = 4096;        ///< of all layers
inline constexpr std::size_t max_map_tile_bytes = 65535;  ///< of one tile's file: it fits an uplinked file
inline constexpr double map_share = 0.25;             ///< of the storage budget, beside which the files of a map lie
inline constexpr std::size_t max_map_features = 256;  ///< of one tile, in one light
inline constexpr std::size_t max_fix_points = 32;     ///< patches of a keyframe that its fix keeps

// Records and the store
inline constexpr std::size_t max_record_types = 48;
inline constexpr std::size_t max_record_bytes = 1024;
inline constexpr std::size_t max_record_fields = 48;
inline constexpr std::size_t max_blob_fields = 4;  ///< of one record
inline constexpr std::size_t max_path_bytes = 512;
inline constexpr std::size_t timing_bins = 20;       ///< of histograms of time, in powers of two of a microsecond
inline constexpr std::int64_t max_starts = 1'000;    ///< the newest stay on board
inline constexpr std::int64_t max_events = 20'000;   ///< the newest stay on board
inline constexpr std::int64_t max_commands = 1'000;  ///< the newest stay on board

// Executive
inline constexpr std::size_t max_components = 20;
inline constexpr std::size_t max_schedule_slots = 64;

static_assert(max_image_width >= min_image_side && max_image_height >= min_image_side);
static_assert(max_matches <= 65535, "match indices are 16 bit");
static_assert(max_calibration_views <= 8, "masks have 8 bits");
static_assert(max_bundle_points <= 65535, "point indices are 16 bit");
static_assert(place_vocabulary % place_vocabulary_places == 0 &&
                  place_vocabulary / place_vocabulary_places <= indexed_place_features,
              "every one of the first places gives as many words");
static_assert(max_bundle_observations >= 2 * max_bundle_points, "every point needs two views");
static_assert(max_disparities < max_rectified_width);
static_assert(max_rectified_width <= 32767, "disparities in 1/16 px must fit 32 bit products");

}  // namespace ilp::limits
