// Numbers of the tables and plots, worked out by hand.

#include <gtest/gtest.h>

#include <cmath>

#include "sim/tools/campaign/result_table.hpp"
#include "sim/tools/campaign/sweep_plot.hpp"

namespace ilp::batch {
namespace {

using Points = std::vector<std::pair<double, double>>;

Job job(const std::string& kind, const std::string& x, std::uint64_t seed) {
  Job made;
  made.name = kind + x + "-" + std::to_string(seed);
  made.axes = {{"flight.kind", kind}, {"world.x", x}, {"seed", std::to_string(seed)}};
  return made;
}

JobResult scored(std::map<std::string, std::optional<double>> summary) {
  JobResult result;
  result.score.complete = true;
  result.score.summary = std::move(summary);
  return result;
}

JobResult failed(const std::string& reason) {
  JobResult result;
  result.failure = reason;
  return result;
}

/// line at x = 1: 1, 2, 6; balloon at x = 1: 4 and a failure; line at x = 0.5: no number, and not run.
class ResultTable : public testing::Test {
 protected:
  std::vector<Job> jobs{job("line", "1", 1),    job("line", "1", 2),   job("line", "1", 3),  job("balloon", "1", 1),
                        job("balloon", "1", 2), job("line", "0.5", 1), job("line", "0.5", 2)};
  JobResults results{scored({{"position_mean_percent", 1.0}, {"completeness", 0.9}, {"drift_percent", 0.25}}),
                     scored({{"position_mean_percent", 2.0}, {"completeness", 0.7}}),
                     scored({{"position_mean_percent", 6.0}, {"completeness", 0.8}, {"depth_nes", 0.1}}),
                     scored({{"position_mean_percent", 4.0}, {"new_number", 1.0 / 3}}),
                     failed("ended with status 1, \"so\""),
                     scored({{"position_mean_percent", std::nullopt}}),
                     std::nullopt};
  Campaign campaign;

  ResultTable() {
    campaign.name = "c";
    campaign.columns = {"position_mean_percent", "completeness", "drift_percent", "frames"};
  }
};

TEST_F(ResultTable, MarkdownHasMeanAndWorstOfEachCell) {
  campaign.columns.pop_back();
  EXPECT_EQ(table_markdown(campaign, jobs, results),
            "# c\n\nMean over the seeds, and the worst in parentheses.\n\n"
            "| flight.kind | world.x | flights | position_mean_percent | completeness | drift_percent |\n"
            "| --- | --- | ---: | ---: | ---: | ---: |\n"
            "| line | 1 | 3 | 3.00 (6.00) | 0.800 (0.700) | 0.250 of 1 |\n"
            "| balloon | 1 | 1 of 2 | 4.00 | – | – |\n"
            "| line | 0.5 | 1 of 2 | – | – | – |\n");
}

TEST_F(ResultTable, CsvHasEveryJobInTheOrderOfTheGrid) {
  const std::string csv = table_csv(jobs, results);
  EXPECT_EQ(csv.rfind("job,grid,flight.kind,world.x,seed,result,complete,", 0), 0U);
  std::vector<std::string> lines;
  std::istringstream in(csv);
  for (std::string line; std::getline(in, line);) lines.push_back(line);
  ASSERT_EQ(lines.size(), jobs.size() + 1);
  for (std::size_t i = 0; i < jobs.size(); ++i) EXPECT_EQ(lines[i + 1].rfind(jobs[i].name + ",", 0), 0U);
  EXPECT_NE(lines[4].find("done,true"), std::string::npos);
  EXPECT_NE(lines[4].find("0.3333333333333333"), std::string::npos) << "in full precision";
  EXPECT_NE(lines[5].find("balloon,1,2,failed,,"), std::string::npos);
  EXPECT_NE(lines[5].find(",\"ended with status 1, \"\"so\"\"\""), std::string::npos);
  EXPECT_NE(lines[7].find("not run"), std::string::npos);
  const auto commas = std::count(lines[0].begin(), lines[0].end(), ',');
  EXPECT_EQ(std::count(lines[1].begin(), lines[1].end(), ','), commas);
  EXPECT_NE(lines[0].find(",new_number,failure"), std::string::npos);
}

TEST_F(ResultTable, GridsOfTheSameAxesShareATable) {
  for (std::size_t i = 0; i < 3; ++i) jobs[i].grid = "a";
  for (std::size_t i = 3; i < 5; ++i) jobs[i].grid = "b";
  for (std::size_t i = 5; i < 7; ++i) {
    jobs[i].grid = "c";
    jobs[i].axes.erase(jobs[i].axes.begin());
  }
  const std::vector<CellTable> tables = cell_tables(jobs, results);
  ASSERT_EQ(tables.size(), 2U);
  EXPECT_EQ(tables[0].grids, "a, b");
  ASSERT_EQ(tables[0].cells.size(), 2U);
  EXPECT_EQ(tables[0].cells[1].jobs, (std::vector<std::size_t>{3, 4}));
  EXPECT_EQ(tables[1].axes, std::vector<std::string>{"world.x"});
  EXPECT_EQ(tables[1].cells.size(), 1U);
}

TEST(WorstOf, DependsOnWhatIsGood) {
  const std::vector<double> values{0.9, 0.6, 0.7};
  EXPECT_EQ(worst_of(*find_summary_key("rotation_mean_deg"), values), 0.9);
  EXPECT_EQ(worst_of(*find_summary_key("completeness"), values), 0.6);
  EXPECT_EQ(worst_of(*find_summary_key("sigma1_share"), values), 0.9) << "0.683 is right";
  EXPECT_EQ(worst_of(*find_summary_key("height_bias_percent"), {0.5, -0.8, 0.7}), -0.8);
  EXPECT_TRUE(std::isnan(worst_of(*find_summary_key("frames"), values)));
  EXPECT_TRUE(std::isnan(worst_of(*find_summary_key("completeness"), {})));
}

TEST_F(ResultTable, PlotHasADotForEachFlightAndALineThroughTheMeans) {
  PlotRequest request;
  request.x = "world.x";
  request.y = "position_mean_percent";
  request.series = {"flight.kind"};
  const SweepPlot plot = sweep_plot(request, jobs, results);
  ASSERT_EQ(plot.series.size(), 2U);
  EXPECT_EQ(plot.series[0].name, "line");
  EXPECT_EQ(plot.series[0].dots, (Points{{1, 1}, {1, 2}, {1, 6}}));
  EXPECT_EQ(plot.series[0].means, (Points{{1, 3}}));
  EXPECT_EQ(plot.series[1].dots, (Points{{1, 4}}));
  EXPECT_EQ(plot.without_number, 3U) << "the failure, the missing number, the one not run";
}

TEST_F(ResultTable, PlotNamesWhatIsNoNumberAndScattersScores) {
  PlotRequest request;
  request.x = "flight.kind";
  request.y = "position_mean_percent";
  const SweepPlot named = sweep_plot(request, jobs, results);
  EXPECT_EQ(named.x_names, (std::vector<std::string>{"line", "balloon"}));
  EXPECT_EQ(named.series.at(0).means, (Points{{0, 3}, {1, 4}}));
  request.x = "completeness";
  const SweepPlot scatter = sweep_plot(request, jobs, results);
  EXPECT_EQ(scatter.series.at(0).dots, (Points{{0.9, 1}, {0.7, 2}, {0.8, 6}}));
  EXPECT_TRUE(scatter.series.at(0).means.empty());
}

// Heights of the drawn dots follow the values: the picture is read back.
TEST_F(ResultTable, DrawnDotsStandWhereTheirValuesAre) {
  PlotRequest request;
  request.name = "a <b> & c";
  request.x = "seed";
  request.y = "position_mean_percent";
  request.series = {"flight.kind"};
  const std::string svg =
      svg_file(sweep_plot(request, {jobs[0], jobs[1], jobs[2]}, {results[0], results[1], results[2]}));
  EXPECT_NE(svg.find("a &lt;b&gt; &amp; c"), std::string::npos);
  std::vector<double> x, y;
  for (std::size_t at = 0; (at = svg.find(" cx=\"", at)) != std::string::npos; ++at) {
    x.push_back(std::stod(svg.substr(at + 5)));
    y.push_back(std::stod(svg.substr(svg.find("cy=\"", at) + 4)));
  }
  ASSERT_GE(x.size(), 3U);
  EXPECT_NEAR(x[2] - x[1], x[1] - x[0], 0.11) << "seeds 1, 2, 3";
  EXPECT_GT(x[1], x[0]);
  EXPECT_NEAR((y[1] - y[2]) / (y[0] - y[1]), 4, 0.05) << "values 1, 2, 6, upwards";
}

}  // namespace
}  // namespace ilp::batch
