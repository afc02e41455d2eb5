/* The step of S1 in C: what a compiler makes of the same work without anything around it.

   One robot per world, among discs and segments that never move and that all worlds share: kinematics, collision
   and clearance, the length of the path, arrival, reward, 180 beams in inverse-depth form, the observation in float32, and a new start for ended worlds.
   State is double, rays are float relative to the sensor. See benchmarks/c_twin.py for who calls it. */

#include <math.h>
#include <stdint.h>

#define MOST_PRIMITIVES 256
#define MOST_BEAMS 1088
#define LANES 32

typedef struct {
    int64_t n_discs, n_segments, n_beams, n_padded;
    const double *disc_x, *disc_y, *disc_r; /* (n_discs) [m] */
    const double *ax, *ay, *dx, *dy;        /* (n_segments): begin and extent [m]; counter-clockwise around solid bodies */
    const double *per_square;               /* (n_segments): 1 / length squared [1/m2] */
    const uint8_t *solid;                   /* (n_segments): belongs to a body whose inside is never seen */
    const float *beams_x, *beams_y; /* (n_padded): unit directions in the robot's frame */
    double side, step_time, radius, range_max, goal_threshold, clearance, least_way, max_speed, max_turn;
    double w_progress, w_arrival, w_collision, w_time; /* rewards as paid: per metre, once, once, per step */
    int64_t max_steps;
} Room;

typedef struct {
    double *pose; /* (n, 3) [m, m, rad] */
    double *goal; /* (n, 2) [m] */
    double *way;  /* (n): distance to the goal [m] */
    double *path; /* (n): length of the path [m] */
    double *min_clearance; /* (n): least clearance of the episode [m] */
    int64_t *steps;
    uint64_t *random;
} State;

static double uniform(uint64_t *random, double low, double high) {
    uint64_t z = (*random += 0x9E3779B97F4A7C15ull);
    z = (z ^ (z >> 30)) * 0xBF58476D1CE4E5B9ull;
    z = (z ^ (z >> 27)) * 0x94D049BB133111EBull;
    return low + (high - low) * ((double)((z ^ (z >> 31)) >> 11) * 0x1p-53);
}

/* Surface distance from a disc to the nearest outline [m]; not positive where they touch. A robot that drives 0.1 m a step
   meets the boundary of a solid body before it is within. */
static double clearance_at(const Room *room, double x, double y, double radius) {
    const double *restrict disc_x = room->disc_x, *restrict disc_y = room->disc_y, *restrict disc_r = room->disc_r;
    const double *restrict ax = room->ax, *restrict ay = room->ay, *restrict dx = room->dx, *restrict dy = room->dy;
    const double *restrict per_square = room->per_square;
    double round = 1e300, straight = 1e300;
    for (int64_t d = 0; d < room->n_discs; d++) {
        double px = disc_x[d] - x, py = disc_y[d] - y, gap = sqrt(px * px + py * py) - disc_r[d];
        round = gap < round ? gap : round;
    }
    for (int64_t s = 0; s < room->n_segments; s++) {
        double px = x - ax[s], py = y - ay[s], along = (px * dx[s] + py * dy[s]) * per_square[s];
        along = along < 0.0 ? 0.0 : along > 1.0 ? 1.0 : along;
        px -= along * dx[s];
        py -= along * dy[s];
        double square = px * px + py * py;
        straight = square < straight ? square : straight;
    }
    straight = sqrt(straight);
    return (round < straight ? round : straight) - radius;
}

/* Whether the robot may begin here. What is drawn may lie within a solid body. */
static int is_free(const Room *room, double x, double y) {
    int inside = 0;
    if (clearance_at(room, x, y, room->radius) < room->clearance) return 0;
    for (int64_t s = 0; s < room->n_segments; s++) {
        double ay = room->ay[s], dy = room->dy[s];
        if (!room->solid[s] || (ay > y) == (ay + dy > y)) continue;
        inside ^= x < room->ax[s] + (y - ay) / dy * room->dx[s];
    }
    return !inside;
}

static void draw_free(const Room *room, uint64_t *random, double *x, double *y) {
    do {
        *x = uniform(random, 0.0, room->side);
        *y = uniform(random, 0.0, room->side);
    } while (!is_free(room, *x, *y));
}

static void begin(const Room *room, State *state, int64_t w) {
    double *pose = state->pose + 3 * w, *goal = state->goal + 2 * w, dx, dy;
    draw_free(room, state->random + w, pose, pose + 1);
    pose[2] = uniform(state->random + w, -M_PI, M_PI);
    do {
        draw_free(room, state->random + w, goal, goal + 1);
        dx = goal[0] - pose[0];
        dy = goal[1] - pose[1];
    } while (dx * dx + dy * dy < room->least_way * room->least_way);
    state->way[w] = sqrt(dx * dx + dy * dy);
    state->path[w] = 0.0;
    state->min_clearance[w] = clearance_at(room, pose[0], pose[1], room->radius);
    state->steps[w] = 0;
}

/* Write what the robot sees: 1 - depth beyond its own outline / range. */
static void scan(const Room *room, double x, double y, double cosine, double sine, float *restrict out) {
    float ax[MOST_PRIMITIVES], ay[MOST_PRIMITIVES], bx[MOST_PRIMITIVES], by[MOST_PRIMITIVES];
    float nx[MOST_PRIMITIVES], ny[MOST_PRIMITIVES];
    float cx[MOST_PRIMITIVES], cy[MOST_PRIMITIVES], r2[MOST_PRIMITIVES], scale[MOST_PRIMITIVES];
    float depths[MOST_BEAMS];
    int64_t n_seen = 0, n_round = 0;
    double far = room->range_max;
    for (int64_t d = 0; d < room->n_discs; d++) {
        double dx = room->disc_x[d] - x, dy = room->disc_y[d] - y, r = room->disc_r[d], distance2 = dx * dx + dy * dy;
        if (distance2 > (far + r) * (far + r)) continue;
        cx[n_round] = (float)(cosine * dx + sine * dy);
        cy[n_round] = (float)(cosine * dy - sine * dx);
        r2[n_round] = (float)(r * r);
        scale[n_round++] = (float)(1.0 / (distance2 - r * r));
    }
    for (int64_t s = 0; s < room->n_segments; s++) {
        double x0 = room->ax[s] - x, y0 = room->ay[s] - y, dx = room->dx[s], dy = room->dy[s];
        double x1 = x0 + dx, y1 = y0 + dy, cross = x0 * y1 - y0 * x1;
        if (room->solid[s] && cross >= 0.0) continue;
        if (cross * cross > far * far * (dx * dx + dy * dy)) continue;
        double a_x = cosine * x0 + sine * y0, a_y = cosine * y0 - sine * x0;
        double b_x = cosine * x1 + sine * y1, b_y = cosine * y1 - sine * x1;
        float turn = cross > 0.0 ? 1.0f : -1.0f;
        nx[n_seen] = (float)((b_y - a_y) / cross);
        ny[n_seen] = (float)((a_x - b_x) / cross);
        ax[n_seen] = turn * (float)a_x;
        ay[n_seen] = turn * (float)a_y;
        bx[n_seen] = turn * (float)b_x;
        by[n_seen++] = turn * (float)b_y;
    }
    float least = (float)(1.0 / far), own = (float)room->radius, share = (float)(1.0 / far);
    for (int64_t block = 0; block < room->n_padded; block += LANES) {
        const float *beams_x = room->beams_x + block, *beams_y = room->beams_y + block;
        float inverse[LANES];
        for (int i = 0; i < LANES; i++) inverse[i] = least;
        for (int64_t s = 0; s < n_seen; s++) {
            float p = ax[s], q = ay[s], u = bx[s], v = by[s], along_x = nx[s], along_y = ny[s];
            for (int i = 0; i < LANES; i++) {
                float after = p * beams_y[i] - q * beams_x[i], before = v * beams_x[i] - u * beams_y[i];
                float inner = after < before ? after : before;
                float depth = along_x * beams_x[i] + along_y * beams_y[i];
                depth = inner >= -1e-6f ? depth : 0.0f;
                inverse[i] = depth > inverse[i] ? depth : inverse[i];
            }
        }
        for (int64_t d = 0; d < n_round; d++) {
            float p = cx[d], q = cy[d], square = r2[d], factor = scale[d];
            for (int i = 0; i < LANES; i++) {
                float ahead = p * beams_x[i] + q * beams_y[i], aside = p * beams_y[i] - q * beams_x[i];
                float room_left = square - aside * aside;
                float depth = (ahead + sqrtf(room_left > 0.0f ? room_left : 0.0f)) * factor;
                depth = (room_left < ahead ? room_left : ahead) >= 0.0f ? depth : 0.0f;
                inverse[i] = depth > inverse[i] ? depth : inverse[i];
            }
        }
        for (int i = 0; i < LANES; i++) {
            float depth = 1.0f / inverse[i] - own;
            depths[block + i] = 1.0f - (depth > 0.0f ? depth : 0.0f) * share;
        }
    }
    for (int64_t i = 0; i < room->n_beams; i++) out[i] = depths[i];
}

static void observe(const Room *room, const State *state, int64_t w, double speed, double turn, float *out) {
    const double *pose = state->pose + 3 * w, *goal = state->goal + 2 * w;
    double cosine = cos(pose[2]), sine = sin(pose[2]), dx = goal[0] - pose[0], dy = goal[1] - pose[1];
    double way = sqrt(dx * dx + dy * dy), diagonal = M_SQRT2 * room->side;
    scan(room, pose[0], pose[1], cosine, sine, out);
    out += room->n_beams;
    out[0] = (float)(way < diagonal ? way / diagonal : 1.0);
    out[1] = (float)(way > 0.0 ? (dx * cosine + dy * sine) / way : 1.0);
    out[2] = (float)(way > 0.0 ? (dy * cosine - dx * sine) / way : 0.0);
    out[3] = (float)exp(-way);
    out[4] = (float)(speed / room->max_speed);
    out[5] = (float)(turn / room->max_turn);
}

void twin_begin(const Room *room, State *state, int64_t n, float *observation) {
    for (int64_t w = 0; w < n; w++) {
        begin(room, state, w);
        observe(room, state, w, 0.0, 0.0, observation + w * (room->n_beams + 6));
    }
}

/* One step of all worlds. ended: 0 goes on, 1 success, 2 collision, 3 time limit. */
void twin_step(const Room *room, State *state, int64_t n, const float *actions, int64_t restarts,
               float *observation, double *reward, uint8_t *ended) {
    for (int64_t w = 0; w < n; w++) {
        double *pose = state->pose + 3 * w, *goal = state->goal + 2 * w;
        double ahead = actions[2 * w], left = actions[2 * w + 1];
        ahead = ahead < -1.0 ? -1.0 : ahead > 1.0 ? 1.0 : ahead;
        left = left < -1.0 ? -1.0 : left > 1.0 ? 1.0 : left;
        double speed = 0.5 * (1.0 + ahead) * room->max_speed, turn = left * room->max_turn;
        double ahead_x = speed * cos(pose[2]) * room->step_time, ahead_y = speed * sin(pose[2]) * room->step_time;
        pose[0] += ahead_x;
        pose[1] += ahead_y;
        pose[2] += turn * room->step_time;
        if (pose[2] >= M_PI) pose[2] -= 2.0 * M_PI;
        if (pose[2] < -M_PI) pose[2] += 2.0 * M_PI;
        double gap = clearance_at(room, pose[0], pose[1], room->radius);
        int hit = gap <= 0.0;
        gap = hit ? 0.0 : gap;
        state->min_clearance[w] = gap < state->min_clearance[w] ? gap : state->min_clearance[w];
        state->path[w] += sqrt(ahead_x * ahead_x + ahead_y * ahead_y);
        double dx = goal[0] - pose[0], dy = goal[1] - pose[1], way = sqrt(dx * dx + dy * dy);
        int arrived = !hit && way < room->goal_threshold;
        state->steps[w] += 1;
        reward[w] = room->w_progress * (state->way[w] - way) - room->w_time + (arrived ? room->w_arrival : 0.0) -
                    (hit ? room->w_collision : 0.0);
        state->way[w] = way;
        ended[w] = hit ? 2 : arrived ? 1 : state->steps[w] >= room->max_steps ? 3 : 0;
        if (ended[w] && restarts) {
            begin(room, state, w);
            speed = turn = 0.0;
        } else if (hit) {
            speed = turn = 0.0;
        }
        observe(room, state, w, speed, turn, observation + w * (room->n_beams + 6));
    }
}
