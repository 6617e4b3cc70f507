#include "sim/world/scenario.hpp"

#include <gtest/gtest.h>

#include <functional>
#include <stdexcept>

#include "sim/world/flight.hpp"
#include "sim/world/world_params.hpp"
#include "tests/unit/host/scratch_folder.hpp"

namespace ilp::world {
namespace {

namespace fs = std::filesystem;
using test::says;
using test::ScratchFolder;
using test::text_of;

std::vector<ScenarioEntry> set(std::initializer_list<const char*> texts) {
  std::vector<ScenarioEntry> entries;
  for (const char* text : texts) entries.push_back(parse_override(text));
  return entries;
}

constexpr auto complaint = test::error_of<std::invalid_argument>;

/// Every parameter as text.
std::vector<std::string> texts(Scenario scenario) {
  std::vector<std::string> all;
  for (const ScenarioSection& section : sections(scenario)) {
    for (const Parameter& parameter : section.parameters) {
      all.push_back(std::string(section.name) + "." + std::string(parameter.name) + "=" + parameter_text(parameter));
    }
  }
  for (const ScenarioEntry& fault : scenario.faults) all.push_back("faults." + fault.name + "=" + fault.value);
  return all;
}

/// Gives every number that is not zero a long fraction.
void change_everything(Scenario& scenario) {
  for (const ScenarioSection& section : sections(scenario)) {
    for (const Parameter& parameter : section.parameters) {
      if (double* const* field = std::get_if<double*>(&parameter.field)) **field = **field * (1 - 1.0 / 3e5);
      if (std::uint64_t* const* field = std::get_if<std::uint64_t*>(&parameter.field)) **field += 1ULL << 60U;
      if (bool* const* field = std::get_if<bool*>(&parameter.field))
        **field = !**field && parameter.name == "altimeter";
    }
  }
  scenario.flight.frames = 7;
}

TEST(Scenario, FileThatIsWrittenIsReadAsTheSameScenario) {
  const ScratchFolder folder;
  for (const WorldPreset& preset : world_presets()) {
    Scenario scenario = scenario_preset(preset.name);
    change_everything(scenario);
    scenario.name = "my own";
    scenario.mission_file = (folder / "mission.ini").string();
    scenario.faults = {{"faults", "lost_share", "0.1", ""}, {"faults", "anything", "goes", ""}};
    write_scenario(folder / "scenario.ini", scenario);
    const Scenario read = load_scenario(folder / "scenario.ini", {});
    EXPECT_EQ(texts(read), texts(scenario)) << preset.name;
    write_scenario(folder / "again.ini", read);
    EXPECT_EQ(text_of(folder / "again.ini"), text_of(folder / "scenario.ini"));
  }
}

TEST(Scenario, EveryPresetFliesWithFramesThatOverlapAsStated) {
  ASSERT_GE(world_presets().size(), 2U);
  for (const WorldPreset& preset : world_presets()) {
    SCOPED_TRACE(preset.name);
    const Scenario scenario = load_scenario(std::string(preset.name), {});
    EXPECT_EQ(scenario.name, preset.name);
    EXPECT_EQ(scenario.flight.altitude_m, preset.altitude_m);
    const std::vector<CameraState> states = fly(scenario.flight);
    EXPECT_NO_THROW(check_flight(Terrain(scenario.world), scenario.flight.camera, states));
    // Shift of the middle of the image over level ground, in image widths and heights.
    const CameraModel& camera = scenario.flight.camera;
    double mean = 0;
    for (std::size_t k = 1; k < states.size(); ++k) {
      const Vec3 axis = states[k].rotation.row(2);
      const Vec3 ground = states[k].centre - states[k].centre.z() / axis.z() * axis;
      const Vec3 seen = states[k - 1].rotation * (ground - states[k - 1].centre);
      const double x = camera.fx * std::fabs(seen.x() / seen.z()) / camera.width;
      const double y = camera.fy * std::fabs(seen.y() / seen.z()) / camera.height;
      const double overlap = (1 - x) * (1 - y);
      EXPECT_GT(overlap, 0.87) << "frame " << k;
      mean += overlap / static_cast<double>(states.size() - 1);
    }
    EXPECT_NEAR(mean, 0.95, 0.015);
  }
}

TEST(Scenario, PresetComesFirstThenTheFileThenTheOverrides) {
  const ScratchFolder folder;
  // What counts first need not stand first.
  const fs::path file = folder.write("low.ini",
                                     "[flight]\naltitude_m = 60 ; lower\nframes = 12\n[effects]\nread_noise_grey = 3\n"
                                     "set = none\n\n# more\n[world]\nseed=8\n[scenario]\npreset = mars-plains\n");
  const Scenario scenario = load_scenario(file, set({"flight.frames=14", "world.relief_m=5", "world.relief_m=6"}));
  EXPECT_EQ(scenario.name, "low");
  EXPECT_EQ(scenario.flight.altitude_m, 60);
  EXPECT_EQ(scenario.flight.frames, 14);
  EXPECT_EQ(scenario.world.seed, 8U);
  EXPECT_EQ(scenario.world.relief_m, 6);
  EXPECT_EQ(scenario.effects.read_noise_grey, 3);
  EXPECT_FALSE(scenario.effects.shot_noise);
  EXPECT_EQ(scenario.flight.interval_s, scenario_preset("mars-plains").flight.interval_s);
  EXPECT_TRUE(load_scenario(file, set({"effects.set=realistic"})).effects.shot_noise);
  const std::string_view other = world_presets().back().name;
  const std::string change = "scenario.preset=" + std::string(other);
  const Scenario moved = load_scenario(file, set({change.c_str()}));
  EXPECT_EQ(moved.flight.drift_m_s, world_presets().back().drift_m_s);
  EXPECT_EQ(moved.flight.altitude_m, 60);
}

TEST(Scenario, PathsInAFileAreRelativeToIt) {
  const ScratchFolder folder;
  fs::create_directories(folder / "deep");
  const fs::path file =
      folder.write("deep/s.ini", "[mission]\nfile = ../missions/m.ini\n[world]\nheightmap = dem.tif\n");
  const Scenario scenario = load_scenario(file, {});
  EXPECT_EQ(scenario.mission_file, (folder / "missions/m.ini").string());
  EXPECT_EQ(scenario.world.heightmap, (folder / "deep/dem.tif").string());
  EXPECT_EQ(load_scenario(file, set({"world.heightmap="})).world.heightmap, "");
}

TEST(Scenario, AHeightMapIsNotRefusedForParametersOfGroundThatItReplaces) {
  const auto refusal = [](std::initializer_list<const char*> more) {
    // Posts that no generated ground of this preset may have.
    std::vector<ScenarioEntry> entries = set({"world.post_spacing_m=50"});
    for (const ScenarioEntry& entry : set(more)) entries.push_back(entry);
    return complaint([&] { (void)load_scenario("mars-plains", entries); });
  };
  EXPECT_TRUE(says(refusal({}), "at least two post spacings"));
  EXPECT_EQ(refusal({"world.heightmap=dem.tif"}), "");
  // With landforms on the map, theirs count.
  EXPECT_TRUE(
      says(refusal({"world.heightmap=dem.tif", "world.heightmap_landforms=true"}), "at least one post spacing"));
}

TEST(Scenario, FaultsAreHandedOnAndOverridden) {
  const ScratchFolder folder;
  const fs::path file = folder.write("s.ini", "[faults]\nlost_share = 0.1\nblack_share = 0.2\n");
  const Scenario scenario = load_scenario(file, set({"faults.lost_share=0.3"}));
  ASSERT_EQ(scenario.faults.size(), 2U);
  EXPECT_EQ(scenario.faults[0].name, "black_share");
  EXPECT_EQ(scenario.faults[0].value, "0.2");
  EXPECT_TRUE(says(scenario.faults[0].origin, "s.ini, line 3"));
  EXPECT_EQ(scenario.faults[1].value, "0.3");
}

TEST(Scenario, SmallerImageIsCentredUnlessItsPrincipalPointIsGiven) {
  const Scenario centre = load_scenario("mars-plains", set({"camera.width=320", "camera.height=240"}));
  EXPECT_EQ(centre.flight.camera.cx, 159.5);
  EXPECT_EQ(centre.flight.camera.cy, 119.5);
  EXPECT_EQ(load_scenario("mars-plains", set({"camera.width=320", "camera.cx=150"})).flight.camera.cx, 150);
}

TEST(Scenario, OverridesThatAreWrongAreNamed) {
  const auto load = [](const char* text) {
    return complaint([&] { (void)load_scenario("mars-plains", set({text})); });
  };
  for (const char* text : {"altitude_m=3", "flight.altitude_m", "=3", ".a=3", "flight.=3", ""}) {
    EXPECT_TRUE(says(load(text), "expected section.name=value")) << text;
  }
  EXPECT_TRUE(says(load("flight.altitude_m=high"), "--set: [flight] altitude_m = high: expected a number from"));
  EXPECT_TRUE(says(load("flight.altitud=3"), "[flight] altitud: no such parameter; there are seed, kind,"));
  EXPECT_TRUE(says(load("fligth.frames=3"), "[fligth]: no such section; there are scenario, world, flight, camera"));
  EXPECT_TRUE(
      says(load("overlap.target_overlap=0.7"), "is a parameter of the flight software, which a file of --mission"));
  EXPECT_TRUE(says(load("navigation.use_navigation=1"), "which a file of --mission sets"));
  EXPECT_FALSE(says(load("fligth.frames=3"), "--mission")) << "it is no parameter of anything";
  EXPECT_TRUE(says(load("scenario.preset=pluto"), "[scenario] preset = pluto: expected one of "));
  EXPECT_TRUE(says(load("effects.set=all"), "[effects] set = all: expected realistic or none"));
  EXPECT_TRUE(says(load("camera.width=9999"), "[camera] width = 9999: expected a whole number from 64 to"));
  EXPECT_TRUE(says(load("flight.kind=train"), "scenario mars-plains: [flight] kind = train: expected balloon"));
  EXPECT_TRUE(says(load("camera.k1=-3"),
                   "scenario mars-plains: [camera]: argument distortion (expected: invertible over the whole image)"));
  EXPECT_TRUE(says(load("world.shortest_wavelength_m=0.01"), "shortest_wavelength_m"));
  EXPECT_TRUE(says(complaint([] { (void)load_scenario("pluto", {}); }), "scenario pluto: expected a file or one of "));
}

TEST(Scenario, FilesThatAreWrongAreNamedWithTheirLine) {
  const ScratchFolder folder;
  const auto load = [&](const std::string& text) {
    const fs::path file = folder.write("bad.ini", text);
    return complaint([&] { (void)load_scenario(file, {}); });
  };
  EXPECT_TRUE(says(load("[flight]\n\nframes = many\n"), "bad.ini, line 3: [flight] frames = many: expected a whole"));
  EXPECT_TRUE(says(load("[flight]\nframe = 3\n"), "bad.ini, line 2: [flight] frame: no such parameter"));
  EXPECT_TRUE(says(load("; x\n[fly]\nframes = 3\n"), "bad.ini, line 3: [fly]: no such section"));
  EXPECT_TRUE(says(load("frames = 3\n"), "bad.ini, line 1: []: no such section"));
  EXPECT_TRUE(says(load("[flight]\nframes = 3\nwhat\n"), "bad.ini, line 3: expected [section], name = value"));
  EXPECT_TRUE(says(load("[flight\nframes = 3\n"), "bad.ini, line 1: expected [section]"));
  EXPECT_TRUE(says(load("[flight]\nframes = 3\nframes = 4\n"), "line 3: [flight] frames is given a second time"));
  EXPECT_TRUE(says(load("[flight]\nframes = 3\n  frames = 4\n"), "line 3: [flight] frames is given a second time"));
  EXPECT_TRUE(says(load("[scenario]\npreset = pluto\n"), "bad.ini, line 2: [scenario] preset = pluto: expected one"));
  EXPECT_TRUE(says(load("[world]\nheightmap = " + std::string(300, 'x') + "\n"), "line 2: expected at most 190"));
  EXPECT_TRUE(says(load("[flight]\n" + std::string(80, 'x') + " = 3\n"), "bad.ini, line 2: [flight] xxxx"));
  EXPECT_TRUE(says(load(std::string("[flight]\n\0\0frames = 3\n", 22)), "bad.ini, line 2"));
  EXPECT_TRUE(says(complaint([&] { (void)load_scenario(folder.path(), {}); }), "cannot be read"));
}

TEST(Scenario, ValuesThatAFileWouldLoseAreNotWritten) {
  const ScratchFolder folder;
  for (const std::string& name : {std::string(" indented"), std::string("a ;b"), std::string("two\nlines"),
                                  std::string(300, 'x'), std::string("; comment")}) {
    Scenario scenario = scenario_preset("mars-plains");
    scenario.name = name;
    EXPECT_TRUE(says(complaint([&] { write_scenario(folder / "s.ini", scenario); }), "[scenario] name")) << name;
  }
}

}  // namespace
}  // namespace ilp::world
