// Whose turn it is. Start-time fair queueing (Goyal, Vin and Cheng, SIGCOMM 1996), in the form that the same
// authors gave it for processors, where what a task takes is known only when it has run (Goyal, Guo and Vin, "A
// hierarchical CPU scheduler for multimedia operating systems", OSDI 1996). Each client (a name, an address) has
// one tag for all that it asks:
//
//     tag = processor seconds that were used for it so far / its weight
//
// The client with the least tag is served next. So among clients that always have work each gets its weight's share
// of the processors, whatever the others queue, run or call urgent.
//
// Who comes back after a rest has at most kCredit less than those who computed meanwhile (as sleepers have in the
// Completely Fair Scheduler of Linux): who asks for little goes before who asks for much. And nobody has more than
// kMostDebt more than they: who had processors that they could not use owes them no more than that.
//
// How urgent a task is counts as a lead in that order (Duda and Cheriton, "Borrowed-virtual-time scheduling", SOSP
// 1999): it decides between tasks of one client, and between clients that have used about as much; but no client gets
// more processor time by calling its work urgent. A second of background work counts as kBackgroundCost seconds: beside work that
// somebody waits for it gets a fifth of the time.
#pragma once

#include <algorithm>
#include <array>
#include <chrono>
#include <cstddef>
#include <cstdint>
#include <deque>
#include <functional>
#include <map>
#include <memory>
#include <optional>
#include <queue>
#include <string>
#include <utility>
#include <vector>

#include "server/tenants/account.hpp"

namespace fracture {

/// The most urgent first.
enum class Priority { kRealtime, kBatch, kBackground };
inline constexpr std::array kPriorities = {Priority::kRealtime, Priority::kBatch, Priority::kBackground};

/// Whose turn a task takes.
struct Flow {
  std::string name{};
  double weight = 1;                            ///< more than 0
  std::shared_ptr<tenants::Account> account{};  ///< of which its use is taken; null: of none
};

/// Not thread-safe. Item has `std::uint64_t id`, which grows with the arrival, `double cost` in seconds, `Flow flow`,
/// and `arrival`, a time.
template <class Item>
class FairQueue {
 public:
  static constexpr double kCredit = 0.6, kMostDebt = 1;  // seconds
  /// A class has so many seconds less than the next one. Little: each of many clients that come after a rest may be ahead
  /// of a less urgent one by so much.
  static constexpr double kLead = 0.03;
  static constexpr double kBackgroundCost = 4;
  /// Within a client, a task is served before more urgent ones that came this much later.
  static constexpr std::chrono::milliseconds kAging{1000};

  /// What a second of a class counts as.
  static constexpr double cost_of(Priority priority) {
    return priority == Priority::kBackground ? kBackgroundCost : 1;
  }

  struct Line {
    bool empty() const { return resumed.empty() && queue.empty(); }
    /// Resumed and queued tasks take turns.
    bool resumed_is_next() const { return !resumed.empty() && (queue.empty() || !resumed_was_last); }
    double cost() const {
      double cost = 0;
      for (const auto* items : {&resumed, &queue})
        for (const Item& item : *items) cost += item.cost;
      return cost;
    }
    const Item& front() const { return resumed_is_next() ? resumed.front() : queue.front(); }

    bool resumed_was_last = false;
    std::deque<Item> resumed, queue;
  };
  struct Client {
    /// The least goes first.
    double key(Priority priority) const { return FairQueue::key(tag, priority); }
    bool rests() const {
      return running == 0 &&
             std::all_of(lines.begin(), lines.end(), [](const Line& line) { return line.empty(); });
    }
    Line& line(Priority priority) { return lines[static_cast<std::size_t>(priority)]; }
    const Line& line(Priority priority) const { return lines[static_cast<std::size_t>(priority)]; }

    std::string name;
    double weight = 1, tag = 0;
    std::size_t running = 0;  ///< tasks that were taken and have not ended
    std::array<Line, 3> lines;
  };
  struct Next {
    Client* client;
    Priority priority;
    double key() const { return client->key(priority); }
    const Item& item() const { return client->line(priority).front(); }
  };

  // -- what is queued

  /// Behind everything of its client and class that came before it.
  void push(Priority priority, Item item) {
    Client& client = arrives(item.flow);
    insert(client.line(priority).queue, std::move(item));
  }
  /// What goes on, in a line of its own.
  void push_resumed(Priority priority, Item item) {
    Client& client = arrives(item.flow);
    insert(client.line(priority).resumed, std::move(item));
  }

  /// Of each client that has something which may begin, what would be next; the first first.
  template <class May>
  std::vector<Next> candidates(const May& may) {
    std::vector<Next> all;
    for (auto& [name, client] : clients_) {
      std::optional<Next> chosen;
      for (const Priority priority : kPriorities) {
        const Line& line = client.line(priority);
        if (line.empty() || !may(client, priority)) continue;
        if (!chosen || line.front().arrival + kAging < chosen->item().arrival)
          chosen = Next{&client, priority};
      }
      if (chosen) all.push_back(*chosen);
    }
    std::sort(all.begin(), all.end(), [](const Next& a, const Next& b) {
      return std::pair(a.key(), a.item().id) < std::pair(b.key(), b.item().id);
    });
    return all;
  }
  /// Its client runs it from now on, until end().
  Item take(const Next& next) {
    Line& line = next.client->line(next.priority);
    line.resumed_was_last = line.resumed_is_next();
    std::deque<Item>& from = line.resumed_was_last ? line.resumed : line.queue;
    Item item = std::move(from.front());
    from.pop_front();
    ++next.client->running;
    return item;
  }
  void end(Client& client) { --client.running; }

  /// Takes a queued task out again; nothing when it is not here. One that goes on stays.
  std::optional<Item> remove(std::uint64_t id) {
    for (const Priority priority : kPriorities)
      if (std::optional<Item> item = remove(id, priority, &Line::queue)) return item;
    return std::nullopt;
  }
  /// The same of one that goes on.
  std::optional<Item> remove_resumed(std::uint64_t id) {
    for (const Priority priority : kPriorities)
      if (std::optional<Item> item = remove(id, priority, &Line::resumed)) return item;
    return std::nullopt;
  }
  /// A task that waits is of this class from now on. A queued one takes the turn of this flow: true.
  bool move(std::uint64_t id, Priority to, const Flow& flow) {
    for (const Priority priority : kPriorities) {
      if (priority == to) continue;
      if (std::optional<Item> resumed = remove(id, priority, &Line::resumed)) {
        push_resumed(to, std::move(*resumed));
      } else if (std::optional<Item> queued = remove(id, priority, &Line::queue)) {
        queued->flow = flow;
        push(to, std::move(*queued));
        return true;
      }
    }
    return false;
  }
  /// A queued task takes the turn of this flow from now on, if that comes sooner: true. `per_cost`: seconds of a client for one of cost.
  template <class PerCost>
  bool hasten(std::uint64_t id, const Flow& flow, const PerCost& per_cost) {
    for (auto& [name, client] : clients_) {
      if (name == flow.name) continue;
      for (const Priority priority : kPriorities) {
        std::deque<Item>& queue = client.line(priority).queue;
        const auto at =
            std::find_if(queue.begin(), queue.end(), [&](const Item& item) { return item.id == id; });
        if (at == queue.end()) continue;
        const double now = turn_of(client, priority, id, per_cost(client));
        Client& sooner = arrives(flow);
        if (turn_of(sooner, priority, id, per_cost(sooner)) >= now) return false;
        Item item = std::move(*at);
        queue.erase(at);
        item.flow = flow;
        push(priority, std::move(item));
        return true;
      }
    }
    return false;
  }
  /// A task that waits; null when it does not.
  Item* find(std::uint64_t id) {
    for (auto& [name, client] : clients_)
      for (Line& line : client.lines)
        for (std::deque<Item>* items : {&line.resumed, &line.queue})
          for (Item& item : *items)
            if (item.id == id) return &item;
    return nullptr;
  }

  // -- what was used

  /// So many seconds were used for this flow, in this class.
  void charge(Priority priority, const Flow& flow, double seconds) {
    Client& client = arrives(flow);
    client.tag = std::max(client.tag, now_ - kCredit) + cost_of(priority) * seconds / client.weight;
    client.tag = std::min(client.tag, now_ + kMostDebt);
  }
  /// The least tag of those who compute.
  void advance(double tag) { now_ = std::max(now_, tag); }

  // -- figures

  bool empty() const { return size() == 0; }
  std::size_t size() const {
    std::size_t size = 0;
    for (const Priority priority : kPriorities) size += this->size(priority) + resumed(priority);
    return size;
  }
  /// Queued for the first time.
  std::size_t size(Priority priority) const {
    return sum(priority, [](const Line& line) { return line.queue.size(); });
  }
  std::size_t resumed(Priority priority) const {
    return sum(priority, [](const Line& line) { return line.resumed.size(); });
  }
  std::size_t size_of(const std::string& flow, Priority priority) const {
    const auto at = clients_.find(flow);
    return at == clients_.end() ? 0 : at->second.line(priority).queue.size();
  }
  /// Flows with something queued, but for this one.
  std::size_t others_than(const std::string& flow, Priority priority) const {
    return sum(priority, [](const Line& line) { return static_cast<std::size_t>(!line.queue.empty()); }) -
           (size_of(flow, priority) > 0 ? 1 : 0);
  }

  /// Ids of what is queued, in the order in which that would begin if nothing came, one processor did all of it, and
  /// costs were right.
  std::vector<std::uint64_t> order() const {
    struct Place {
      bool operator>(const Place& other) const { return std::pair(key, id) > std::pair(other.key, other.id); }
      double key;
      std::uint64_t id;
      const Client* client;
      std::size_t line, k;
      double tag;
    };
    std::priority_queue<Place, std::vector<Place>, std::greater<>> turns;
    const auto add = [&turns](const Client& client, std::size_t line, std::size_t k, double tag) {
      for (; line < client.lines.size(); ++line, k = 0)
        if (const auto& queue = client.lines[line].queue; k < queue.size())
          return turns.push({key(tag, static_cast<Priority>(line)), queue[k].id, &client, line, k, tag});
    };
    for (const auto& [name, client] : clients_) add(client, 0, 0, client.tag);
    std::vector<std::uint64_t> served;
    while (!turns.empty()) {
      const Place turn = turns.top();
      turns.pop();
      served.push_back(turn.id);
      const double cost =
          turn.client->lines[turn.line].queue[turn.k].cost * cost_of(static_cast<Priority>(turn.line));
      add(*turn.client, turn.line, turn.k + 1, turn.tag + cost / turn.client->weight);
    }
    return served;
  }

  /// Seconds of what would be computed before a new task of this flow and class ends that takes so many `seconds`, but for
  /// itself. `left`: seconds that the tasks of a client and class should still take, whether they wait or run.
  template <class Left>
  double ahead_of(Priority priority, const Flow& flow, double seconds, const Left& left) const {
    Client mine;
    mine.tag = now_ - kCredit;
    double ahead = 0, own = cost_of(priority) * seconds / flow.weight;
    const auto at = clients_.find(flow.name);
    if (at != clients_.end()) {
      mine.tag = at->second.rests() ? std::max(at->second.tag, mine.tag) : at->second.tag;
      for (const Priority of : kPriorities) {
        if (of > priority) break;
        ahead += left(at->second, of);
        own += cost_of(of) * left(at->second, of) / flow.weight;
      }
    }
    const double ends = mine.key(priority) + own;
    for (const auto& [name, client] : clients_) {
      if (name == flow.name) continue;
      double used = 0;
      for (const Priority of : kPriorities) {
        const double until = std::max(0.0, ends - client.key(of) - used) * client.weight / cost_of(of);
        const double computed = std::min(left(client, of), until);
        ahead += computed;
        used += cost_of(of) * computed / client.weight;
      }
    }
    return ahead;
  }

  /// Seconds of all that is to be computed of this class and of more urgent ones.
  template <class Left>
  double left(Priority priority, const Left& left_of) const {
    double seconds = 0;
    for (const auto& [name, client] : clients_)
      for (const Priority of : kPriorities)
        if (of <= priority) seconds += left_of(client, of);
    return seconds;
  }

  // -- what is remembered

  /// Nothing is queued and nothing runs: the end of a busy period, from which nothing is remembered.
  void idle() {
    clients_.clear();
    now_ = 0;
  }
  /// Forgets clients that rest and owe nothing, so that those who came once leave nothing behind; and where more than
  /// `most` are left, what the others owe.
  void sweep(std::size_t most) {
    std::erase_if(clients_, [this](const auto& entry) {
      return entry.second.rests() && entry.second.tag <= now_ - kCredit;
    });
    if (clients_.size() > most)
      std::erase_if(clients_, [](const auto& entry) { return entry.second.rests(); });
  }
  std::size_t flows() const { return clients_.size(); }

 private:
  static constexpr double key(double tag, Priority priority) {
    return tag - kLead * (1 - static_cast<double>(priority));
  }
  /// The tag of this client when all has been computed that it serves before a queued task of this class and id.
  static double turn_of(const Client& client, Priority priority, std::uint64_t id, double per_cost) {
    double tag = client.tag;
    for (const Priority of : kPriorities)
      for (const auto* items : {&client.line(of).resumed, &client.line(of).queue})
        for (const Item& item : *items)
          if (of < priority || (of == priority && (items == &client.line(of).resumed || item.id < id)))
            tag += cost_of(of) * per_cost * item.cost / client.weight;
    return tag;
  }
  /// The client of this flow, who has rested where it does nothing just now.
  Client& arrives(const Flow& flow) {
    const auto [at, is_new] = clients_.try_emplace(flow.name);
    Client& client = at->second;
    if (is_new) client.name = flow.name;
    if (is_new || client.rests()) client.tag = is_new ? now_ - kCredit : std::max(client.tag, now_ - kCredit);
    client.weight = flow.weight;
    return client;
  }
  static void insert(std::deque<Item>& items, Item item) {
    const auto behind =
        std::find_if(items.begin(), items.end(), [&](const Item& other) { return other.id > item.id; });
    items.insert(behind, std::move(item));
  }
  std::optional<Item> remove(std::uint64_t id, Priority priority, std::deque<Item> Line::*items) {
    for (auto& [name, client] : clients_) {
      std::deque<Item>& from = client.line(priority).*items;
      const auto at = std::find_if(from.begin(), from.end(), [&](const Item& item) { return item.id == id; });
      if (at == from.end()) continue;
      Item item = std::move(*at);
      from.erase(at);
      return item;
    }
    return std::nullopt;
  }
  template <class Count>
  std::size_t sum(Priority priority, const Count& count) const {
    std::size_t sum = 0;
    for (const auto& [name, client] : clients_) sum += count(client.line(priority));
    return sum;
  }

  std::map<std::string, Client> clients_;
  double now_ = 0;
};

}  // namespace fracture
