#include "sim/ground/received_flight.hpp"

#include <map>
#include <optional>
#include <ostream>
#include <set>
#include <stdexcept>
#include <string>

#include "sim/ground/control/control_system.hpp"
#include "sim/ground/export/quick_looks.hpp"
#include "sim/ground/export/shared_catalogue.hpp"
#include "sim/ground/intake/flight_model.hpp"
#include "sim/ground/map/damaged_catalogue.hpp"
#include "sim/ground/model/height_steps.hpp"
#include "sim/ground/model/joined_model.hpp"
#include "sim/ground/tasks/work_result.hpp"
#include "sim/ground/viewer/viewer_page.hpp"
#include "sim/host/files.hpp"
#include "sim/host/progress.hpp"
#include "sim/host/text_format.hpp"

namespace ilp::ground {
namespace {
namespace fs = std::filesystem;

std::string nothing_usable(const fs::path& folder, const intake::Outbox& outbox) {
  return "nothing usable in " + folder.string() + ": " +
         (outbox.files.empty() ? "the folder is empty; name the one in which files of the downlink have arrived"
                               : host::counted(outbox.files.size(), "file") +
                                     ", none of them whole; wait until they have arrived, or name another folder");
}

// The results of an earlier run, with more to see, stay.
void write_empty_viewer(const fs::path& out, const std::string& title, const std::string& reason) {
  if (!viewer::viewer_available() || fs::exists(out / "report.html")) return;
  host::make_output_folder(out);
  host::write_file(out / "viewer.html", viewer::viewer_empty_html(title, reason));
}

[[noreturn]] void stop_for_nothing(const GroundOptions& options, const report::Report& report) {
  const std::string reason = nothing_usable(options.outbox, report.outbox);
  write_empty_viewer(options.out, report.title, reason);
  throw std::runtime_error(reason);
}

void forget(const fs::path& out, const fs::path& catalogue) {
  fs::remove_all(tasks::work_folder(out));
  for (const char* part : {"", "-wal", "-shm"}) fs::remove(catalogue.string() + part);
  forget_record(out);
}

intake::Outbox everything_held(const GroundOptions& options, intake::Catalogue& catalogue) {
  intake::Outbox outbox = catalogue.outbox();
  if (!options.flight_db.empty()) {
    // What came down is read last, so that it stands over what the database says.
    std::vector<intake::RecordEntry> onboard = intake::read_flight_database(options.flight_db);
    onboard.insert(onboard.end(), std::make_move_iterator(outbox.records.begin()),
                   std::make_move_iterator(outbox.records.end()));
    outbox.records = std::move(onboard);
  }
  return outbox;
}

/// Products that do not decode leave the catalogue; whether there were any.
bool reject_faulty(report::Report& report, intake::Catalogue& catalogue) {
  std::map<std::string, const intake::ReceivedFile*> files;
  for (const intake::ReceivedFile& file : report.outbox.files) files[file.name] = &file;
  bool any = false;
  for (auto& [id, quick_look] : report.quick_looks) {
    intake::Keyframe& keyframe = report.flight.keyframes.at(id);
    for (std::size_t kind = 0; kind < quick_look.faults.size(); ++kind) {
      if (quick_look.faults[kind].empty() || !keyframe.products[kind]) continue;
      const auto file = files.find(keyframe.products[kind]->file);
      if (file == files.end()) continue;
      intake::ReceivedFile faulty = *file->second;
      faulty.fault = quick_look.faults[kind];
      catalogue.reject(faulty);
      any = true;
    }
  }
  return any;
}

/// The catalogue tells flights apart by their files. Where an earlier run has kept none, the folder has to be the same.
void refuse_another_downlink(const GroundOptions& options, const RunRecord& before) {
  if (before.outbox.empty() || before.outbox == name_of_outbox(options.outbox)) return;
  throw std::runtime_error("the results in " + options.out.string() + " are of the downlink " + before.outbox +
                           ": choose another folder for those of " + options.outbox.string() +
                           ", or begin afresh (--afresh)");
}

void report_intake(const intake::Catalogue& catalogue, const intake::Catalogue::Intake& intake,
                   std::ostream& messages) {
  if (catalogue.was_quarantined()) {
    messages << "the catalogue was damaged and is quarantined: started over from the files that are there\n";
  }
  if (intake.fresh < intake.files) {
    messages << host::counted(intake.fresh, "file") << " new, " << intake.files - intake.fresh << " known\n";
  }
}

void report_skipped(const intake::Outbox& outbox, std::ostream& messages) {
  for (const intake::ReceivedFile& file : outbox.files) {
    if (!file.fault.empty()) messages << "skipped " << file.name << ": " << file.fault << "\n";
  }
}

/// Body::none for no name.
Body body_named(const std::string& name) {
  for (const Body body : {Body::mars, Body::titan, Body::venus, Body::moon, Body::earth}) {
    if (name == name_of(body)) return body;
  }
  return Body::none;
}

void take_in_work(const fs::path& out, intake::Catalogue& catalogue, std::ostream& messages) {
  const tasks::TakenIn taken =
      tasks::take_in_results(out, catalogue, host::Progress(messages, "Taking in results of tasks"));
  if (taken.results > 0) messages << host::counted(taken.results, "result") << " of tasks taken in\n";
  if (taken.damaged > 0) messages << host::counted(taken.damaged, "result") << " of tasks damaged: done again\n";
}

}  // namespace

void naming_catalogue(const GroundOptions& options, const std::function<void()>& step) {
  try {
    step();
  } catch (const map::DamagedCatalogue& part) {
    const std::string place =
        options.catalogue.empty() ? (options.out / intake::catalogue_name).string() : options.catalogue;
    throw std::runtime_error(place + " is damaged: " + part.what() + "; --afresh makes it again from the outbox");
  }
}

std::unique_ptr<intake::Catalogue> open_catalogue(const GroundOptions& options, bool known_valid) {
  if (options.catalogue.empty())
    return std::make_unique<intake::Catalogue>(options.out / intake::catalogue_name, known_valid);
  return std::make_unique<intake::Catalogue>(options.catalogue, mission_of(options), options.out);
}

std::unique_ptr<intake::Catalogue> open_and_take_in(const GroundOptions& options, const report::Report& report,
                                                    RunRecord& before, std::ostream& messages) {
  const fs::path catalogue_file = options.out / intake::catalogue_name;
  const bool shared = !options.catalogue.empty();
  if (shared) exports::prepare_shared_catalogue(options.catalogue);
  if (options.afresh) forget(options.out, catalogue_file);
  before = read_record(options.out);
  (void)keep_valid_files(options.out, options.check, before, messages);
  if (!shared && !options.afresh && !fs::exists(catalogue_file)) refuse_another_downlink(options, before);
  if (!shared && intake::files_of(options.outbox).empty() && !fs::exists(catalogue_file))
    stop_for_nothing(options, report);
  host::make_output_folder(options.out);
  auto catalogue = open_catalogue(options, before.files.contains(intake::catalogue_name));
  if (shared && options.afresh) catalogue->forget_everything();
  catalogue->keep_mark(0);
  const intake::Catalogue::Intake intake =
      catalogue->take_in(options.outbox, host::Progress(messages, "Taking in files"));
  report_intake(*catalogue, intake, messages);
  take_in_work(options.out, *catalogue, messages);
  return catalogue;
}

void place_by_points(const GroundOptions& options, report::Report& report) {
  control::ControlFile file = control::read_control_file(options.control);
  control::ControlSystem system{{}, options.control_crs, options.geoid};
  const std::string key =
      options.control_body.empty() && control::is_on_earth(file, system) ? "earth" : options.control_body;
  const exports::Body* const body = exports::find_body(key);
  if (body != nullptr) system.body_crs = body->crs;
  control::resolve(system, file);
  if (report.flight.camera) {
    std::set<std::string> known;
    for (const auto& [id, keyframe] : report.flight.keyframes) known.insert(host::image_key(keyframe.name));
    std::optional<intake::FlightInfo> info = report.info;
    if (!info && !options.flight_info.empty()) info = intake::read_flight_info(options.flight_info);
    const double binning = info ? info->binning.value_or(1) : 1;
    const control::FlownImages images{
        report.flight.camera->width, report.flight.camera->height,
        binning >= 1 && binning <= 64 ? static_cast<int>(binning) : 1,
        [&known](const std::string& image) { return known.contains(host::image_key(image)); }};
    control::fit_marks(images, options.control_original, file);
  }
  report.control = control::place_by_control(file, body_named(key), system.body_crs, report.flight);
}

void index_held(const GroundOptions& options, intake::Catalogue& catalogue, report::Report& report,
                std::ostream& messages) {
  report.outbox = everything_held(options, catalogue);
  report.flight = intake::index_flight(report.outbox);
  // The others are in the flight now.
  std::erase_if(report.outbox.records, [](const auto& entry) { return entry.type != RecordType::downlink; });
  report.outbox.records.shrink_to_fit();
  report.fixes = fixes::fixes_of(report.flight);
  report.joined = model::join_strips(report.flight, host::LongPhases(messages), &catalogue);
  if (!options.control.empty()) place_by_points(options, report);
}

/// Until no product is found damaged: another version of it may be held. Every round takes at least one file out.
void decode_held(const GroundOptions& options, intake::Catalogue& catalogue, report::Report& report,
                 std::ostream& messages) {
  do {
    index_held(options, catalogue, report, messages);
    report.quick_looks = exports::make_quick_looks(report.flight, options.out / "keyframes", catalogue, messages);
  } while (reject_faulty(report, catalogue));
  report.whole_quick_look = [&report, &catalogue](std::int64_t id) {
    return exports::known_quick_look(report.flight, id, report.quick_looks.at(id), catalogue);
  };
  model::state_height_steps(report.flight, report.joined);
  report_skipped(report.outbox, messages);
  if (report::totals(report).files_used == 0) stop_for_nothing(options, report);
}

std::vector<const intake::Strip*> strips_with_poses_first(const intake::Flight& flight) {
  std::vector<const intake::Strip*> posed, others;
  for (const auto& [id, strip] : flight.strips) {
    if (strip.keyframes.empty()) continue;
    (intake::track_of(flight, strip).empty() ? others : posed).push_back(&strip);
  }
  posed.insert(posed.end(), others.begin(), others.end());
  return posed;
}

map::KeyframeViews views_of(const report::Report& report, const intake::Strip& strip) {
  map::KeyframeViews views;
  for (const std::int64_t id : strip.keyframes) {
    const map::KeyframeQuickLook& quick_look = report.quick_looks.at(id);
    if (quick_look.ground_step > 0) views[id] = map::view_of(quick_look);
  }
  return views;
}

}  // namespace ilp::ground
