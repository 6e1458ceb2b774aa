package org.opensourcephysics.cabrillo.tracker;

import java.lang.reflect.Field;
import java.lang.reflect.Method;
import java.nio.charset.StandardCharsets;
import java.nio.file.Files;
import java.nio.file.Paths;
import java.util.ArrayList;
import java.util.BitSet;
import java.util.HashMap;
import java.util.Locale;
import javax.swing.SwingUtilities;
import org.opensourcephysics.controls.XMLControlElement;
import org.opensourcephysics.media.core.ImageCoordSystem;

/** The film of write.py through Tracker's own project file and export; README.md says how it is run. */
public class Film {
    static final int FRAMES = 12;
    static final double[] ORIGIN = {20.0, 300.0};
    static final double SCALE = 2.0;

    public static void main(String[] folder) throws Exception {
        Locale.setDefault(Locale.US);
        SwingUtilities.invokeAndWait(() -> {
            try {
                write(folder[0]);
            } catch (Exception error) {
                error.printStackTrace();
            }
        });
        System.exit(0);
    }

    static void write(String folder) throws Exception {
        TFrame window = new TFrame();
        TrackerPanel panel = new TrackerPanel(window);
        window.addTab(panel, 0, null);
        panel.getPlayer().getVideoClip().setStepCount(FRAMES);
        panel.getPlayer().getClipControl().setFrameDuration(40.0);
        ImageCoordSystem axes = panel.getCoords();
        axes.setAllScalesXY(SCALE, SCALE);
        axes.setAllOriginsXY(ORIGIN[0], ORIGIN[1]);
        PointMass[] masses = {new PointMass(), new PointMass()};
        for (int mass = 0; mass < 2; mass++) {
            masses[mass].setName("mass " + "AB".charAt(mass));
            panel.addTrack(masses[mass]);
            for (int frame = 0; frame < FRAMES; frame++) {
                if (mass == 0) masses[0].createStep(frame, 100.0 + 3.25 * frame, 80.0 + 1.5 * frame);
                else if (frame != 4 && frame != 5)
                    masses[1].createStep(frame, 300.0 - 2.0 * frame, 40.0 + 0.5 * frame * frame);
            }
        }
        new XMLControlElement(panel).write(folder + "/tracker.trk");
        export(folder, "one", panel, masses, 1);
        export(folder, "two", panel, masses, 2);
        axes.setAllAngles(Math.toRadians(30.0));
        new XMLControlElement(panel).write(folder + "/tracker_turned.trk");
        export(folder, "turned", panel, masses, 2);
    }

    /** What File, Export, Data writes of x and y of so many tracks at full precision, separated by tabs. */
    @SuppressWarnings("unchecked")
    static void export(String folder, String name, TrackerPanel panel, PointMass[] masses, int count)
            throws Exception {
        ExportDataDialog dialog = ExportDataDialog.getDialog(panel);
        Field formatted = ExportDataDialog.class.getDeclaredField("asFormatted");
        formatted.setAccessible(true);
        formatted.setBoolean(dialog, false);
        TrackerIO.setDelimiter("\t");
        for (int mass = 0; mass < masses.length; mass++)
            call(dialog, "selectTrack", TTrack.class, masses[mass], boolean.class, mass < count);
        Field columns = ExportDataDialog.class.getDeclaredField("allColumnsMap");
        columns.setAccessible(true);
        ArrayList<String> all = ((HashMap<Class<?>, ArrayList<String>>) columns.get(null)).get(PointMass.class);
        BitSet chosen = (BitSet) call(dialog, "getSelectedColumnsBitSet", Class.class, PointMass.class);
        chosen.clear();
        chosen.set(all.indexOf("x"));
        chosen.set(all.indexOf("y"));
        String text = (String) call(dialog, "getDataString");
        Files.write(Paths.get(folder, "tracker_" + name + ".txt"), text.getBytes(StandardCharsets.UTF_8));
    }

    static Object call(ExportDataDialog dialog, String name, Object... typesAndValues) throws Exception {
        Class<?>[] types = new Class<?>[typesAndValues.length / 2];
        Object[] values = new Object[types.length];
        for (int at = 0; at < types.length; at++) {
            types[at] = (Class<?>) typesAndValues[2 * at];
            values[at] = typesAndValues[2 * at + 1];
        }
        Method method = ExportDataDialog.class.getDeclaredMethod(name, types);
        method.setAccessible(true);
        return method.invoke(dialog, values);
    }
}
