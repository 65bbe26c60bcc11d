"""The paper: A. Roza, M. Maggiore, "Path Following Controller for a Quadrotor Helicopter", equation by equation.

Goals: converge to the path (G1), fly it at a speed given over the displacement (G2), with a yaw given likewise (G3).

Notation
    X, V         position m and velocity m/s in the inertial frame I: here the vehicle's local NED, z down
    psi, theta, phi   yaw, pitch, roll (ZYX), rad        R   body to inertial: R_nb
    w = (p, q, r)     body rates, rad/s                  J   inertia, diagonal, kg m^2        m, g   mass, gravity
    u1..u4       thrust along -z_b in N, torques about the body axes in N m
    tau          motor torques, N m; f = c tau the rotor thrusts, c = gamma/b = 1/torque_per_thrust
    zeta, zeta_dot    the thrust as a state of the controller (dynamic extension), N, N/s
    chi          the extended state (X, Phi, V, w, zeta, zeta_dot)
    h1, h2       zero on the path       alpha   speed, m/s       beta   yaw, rad       h3, h4   their errors
    mu           unit tangent, grad h1 x grad h2 normalised      eta    arc length along it, m
    xi           (h1, h1', h1'', h1''', h2.., h3, h3', h3'', h4, h4')
    b, D, v      u = D^-1 (-b + v);  v_i = -sum_j k_j d^j h_i/dt^j
    A, J, S      acceleration, jerk and snap of the position (this project's letters, as is Level for the order)

Equation -> function -> test (in tests/law, tests/paths, tests/flights, ...)
    M (section II)         allocation.mixing_matrix, Allocation       test_allocation
    Eq. 1                  motion.acceleration, motion.jerk           test_exact_derivatives, test_closed_loop
    Eq. 2                  flatness.torques, flatness.HeadingRate     test_exact_derivatives, test_closed_loop
    Def. 3.1               paths.implicit, paths.tracing              test_tracing
    Def. 3.2, Eq. 3        implicit.outputs                           test_exact_derivatives
    Def. 3.3               implicit.outputs, feedback.wanted_heading_acceleration    test_exact_derivatives
    Eq. 4                  thrust_range, steering.motors.Extension,   test_blocks, test_rates
                           steering.limits.limit_thrust (rates)
    Lemma 4.1, det D       lie.linearise                              test_exact_derivatives.test_determinant_of_D
    Eq. 6                  reference.reference_motion                 test_closed_loop.test_invariance
    Eq. 7                  implicit.outputs (mu)                      test_exact_derivatives
    Eq. 8                  lie.linearise, lie.solve; factored: feedback.wanted_derivative, flatness.body_acceleration
                                                             test_exact_derivatives (both, and that they are equal)
    Eq. 9                  lie.linear_feedback, feedback.linear, gains.from_poles    test_exact_derivatives, test_gains
    Eq. 10                 (the closed loop)                          test_closed_loop.test_errors_are_linear_and_..
    Lambda, eta (IV.B)     paths.arc.ArcTable, paths.tracing          test_tracing, test_closed_loop
    Eq. 11, Lemma 4.4      reference.reference_motion                 test_closed_loop.test_lemma_4_4
    Prop. 4.2, Remark 4.3  feasibility.report                         test_check.test_the_papers_cases
    Theorem 4.5            (the poles are in the left half plane)     config.mission, test_files
    Section V              configs/missions/paper_case1, paper_case2  test_closed_loop, test_paper_cases

How it is evaluated: recorded once on symbols (recording) and printed as floats; bare: without a vehicle; speed_scale:
factors on the speed.

The level of rates is the same design one order earlier: inputs (zeta_dot, p, q, r), one integrator, relative degree
{3, 3, 2, 1}, det D3 = -zeta^2 cos(phi)/(m^3 cos(theta)) (grad h1 x grad h2) . mu, the same singular set, the same
one-dimensional path following manifold.

Paths beyond the paper's (closest): a curve given by a parametrisation, with the errors taken at its closest point, and
speed and yaw over arc length. On a closed C^4 curve inside the tube Q > 0 (the distance to the evolute: path_radius_m
of `check`) the outputs are smooth, the relative degree and det D are those of Lemma 4.1 with h1, h2 distances in a
parallel-transport frame, and Prop. 4.2 to Theorem 4.5 go through. They do not cover
    - an open path: C is no Jordan curve, Gamma* is an arc and no compact manifold without boundary, so Lemma 4.4's
      diffeomorphism onto S^1 and the last step of Theorem 4.5 (no finite escape, eta in S^1) hold only until its end is
      reached, which is after length/min |alpha| at the latest. The ends are phases of the flight, not of the law.
    - a path that crosses itself: p is no function of X near the crossing. The closest point is followed from the last
      one (paths.curve), so eta is a state and not an output; on the branch that is flown the proof is as before.
    - rounded corners and splines: C^4 only (C^3 at rates), not smooth; no more is differentiated anywhere.
    - an implicit path with speed or yaw over arc length: off the path s' = mu . V is arc length to first order in the
      distance (implicit.arc_along); on the path following manifold it is exact, so the linearisation there is too.

What is wrong in the paper, and what is used here
    1. det D has a factor d^3 too many for its own model, where u2..u4 are torques. Used: without it.
    2. "a height of z = 20 m" is 20 m below the origin, z being down. Used: z = -20.
    3. Prop. 4.2, second component of V': c_phi s_theta s_psi + c_psi s_phi; R gives a minus. Norms are unaffected.
    4. Lemma 4.4: phi and theta lack a division by zeta: phi = asin((s_psi a1 - c_psi a2)/zeta),
       theta = asin((c_psi a1 + s_psi a2)/(zeta c_phi)).
    5. Lemma 4.1's "if and only if" holds where grad h1 and grad h2 are independent: on the path, by definition, but
       not everywhere (the circle x^2 + y^2 - r^2 fails on its axis). Used: the sine between the gradients is watched.
    6. Remark 4.3's |alpha| < sqrt(r g) is sufficient, not necessary: a level circle is regular at any speed.
    7. 5.25 and 66.45 deg: the steady states are atan(0.9/9.81) = 5.2418 and atan(22.5/9.81) = 66.4428 deg.
    8. u = M tau_1 should read u = M tau; c is never given, so motor values cannot be reproduced. Used: c = 60 1/m.
    9. h4 = psi - beta is not wrapped. Used in flight: wrapped.
    10. The rotors' "clockwise" agrees with u4 = tau1 - tau2 + tau3 - tau4 only if seen from below.
    11. alpha > 0 on the paper's circle runs counter-clockwise seen from above (x north, y east, z down); its start
        V = (-1, 0, 0) at (0, 10) flies backwards, mu . V = -1.

Where we depart from it, because a machine has limits: errors are saturated (feedback.Bounds), zeta and zeta_dot are
bounded (thrust_range), linear drag enters A, J and S (motion), and the law is evaluated where its command acts: the
dead time, half a step and the lag of rotors or rate loop ahead (steering.timing). A mission may have h4 on the twist
instead of psi (frames.Heading, flatness.HeadingRate): the relative degree is the same, and det D has 1 in the place of
cos(phi)/cos(theta), so that phi and theta of +-90 deg are singular no more.
"""
