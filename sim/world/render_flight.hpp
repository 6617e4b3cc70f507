// A simulated flight as files: images as a camera would deliver them, and the truth to measure against.
#pragma once

#include <cstddef>
#include <filesystem>
#include <functional>

#include "sim/world/scenario.hpp"

namespace ilp::world {

/// `progress(done, total)` is called once per frame, one call at a time, possibly from another thread; it may be empty.
/// An exception that it throws ends the rendering and is passed on.
using RenderProgress = std::function<void(int done, int total)>;

/// Refuses what render_flight refuses, without writing anything: std::invalid_argument or, for files of the world,
/// std::runtime_error.
void check_scenario(const Scenario& scenario);

/// Writes into `dir`, which is created:
///   images/0001.pgm ...      the frames
///   index.txt                a line `time_ns images/NNNN.pgm` per frame; with flight.altimeter also the height of the
///                            camera above the ground straight below, m
///   cameras.txt              the intrinsics, COLMAP's text format
///   scenario.ini             the scenario as flown
///   truth/poses.txt          name width height fx fy cx cy R(9) C(3) per frame, x_cam = R (X - C); metres, z up
///   truth/depth/0001.pfm ... z-depth in metres of every pixel of the image as taken (distortion included)
///   truth/...                what follows from these: write_truth (truth.hpp)
/// The same scenario gives the same bytes for any number of threads (0: as many as the host has). std::invalid_argument
/// or std::runtime_error says what is wrong; a flight too low over its ground or with the horizon in view is refused
/// before anything is rendered.
void render_flight(const std::filesystem::path& dir, const Scenario& scenario, const RenderProgress& progress = {},
                   std::size_t threads = 0);

}  // namespace ilp::world
