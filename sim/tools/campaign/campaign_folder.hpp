// The folder of a campaign: whose it is, and that one run at a time works in it.
#pragma once

#include <filesystem>

#include "sim/tools/campaign/campaign_file.hpp"

namespace ilp::batch {

/// Creates the folder, locks it until destruction, and keeps a copy of the campaign file there. std::runtime_error when
/// it is another campaign's, somebody else's, not writable, or locked.
class CampaignFolder {
 public:
  CampaignFolder(const Campaign& campaign, const std::filesystem::path& folder);
  ~CampaignFolder();
  CampaignFolder(const CampaignFolder&) = delete;
  CampaignFolder& operator=(const CampaignFolder&) = delete;

  [[nodiscard]] const std::filesystem::path& path() const { return path_; }
  [[nodiscard]] std::filesystem::path job(const std::string& name) const { return path_ / "jobs" / name; }

 private:
  std::filesystem::path path_;
  int lock_ = -1;
};

}  // namespace ilp::batch
